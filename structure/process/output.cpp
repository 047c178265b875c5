#include "structure/process/output.hpp"

#include <string>

namespace tern::structure {

template <int D>
std::vector<double> energy_values(const Case& scene, const Structure<D>& structure) {
  const Energies e = structure.energies();
  std::vector<double> values{e.kinetic, e.strain, e.potential, e.diffusion, e.interface_work};
  if (has_structure_loads(*scene.structure)) values.insert(values.end(), {e.damping, e.load_work, e.clamp_work});
  return values;
}

template <int D>
void write_frame(const Structure<D>& structure, FrameWriter& frames, long step) {
  const Fields<D> fields = structure.fields();
  frames.begin(seconds(structure.time()), step);
  frames.vector<D>("position", "m", fields.position);
  frames.vector<D>("displacement", "m", fields.displacement);
  frames.vector<D>("velocity", "m/s", fields.velocity);
  std::vector<double> component(fields.stress.size());
  constexpr const char* axis = "xyz";
  for (int a = 0; a < D; ++a)
    for (int b = a; b < D; ++b) {
      for (std::size_t p = 0; p < component.size(); ++p) component[p] = fields.stress[p](a, b);
      frames.scalar(std::string("stress_") + axis[a] + axis[b], "Pa", component);
    }
  frames.scalar("von_mises", "Pa", fields.von_mises);
  frames.scalar("J", "1", fields.jacobian);
  frames.scalar("energy_density", "J/m^3", fields.energy_density);
  if (!fields.shell_thickness.empty()) frames.scalar("shell_thickness", "m", fields.shell_thickness);
  const std::vector<std::uint32_t> clamped(fields.clamped.begin(), fields.clamped.end());
  frames.integer("clamped", std::span<const std::uint32_t>(clamped));
  frames.integer("body", std::span<const std::uint32_t>(fields.body));
  frames.side_vector<D>("surface_position", "m", structure.surface().position);
  frames.side_vector<D>("surface_force", D == 2 ? "N/m" : "N", structure.load().force);
  frames.end();
}

template std::vector<double> energy_values<2>(const Case&, const Structure<2>&);
template std::vector<double> energy_values<3>(const Case&, const Structure<3>&);
template void write_frame<2>(const Structure<2>&, FrameWriter&, long);
template void write_frame<3>(const Structure<3>&, FrameWriter&, long);

}  // namespace tern::structure
