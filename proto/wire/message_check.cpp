// The checks of docs/PROTOCOL.md, one function per message kind. The first fault found is the one reported.

#include "proto/wire/message_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "proto/wire/names.hpp"

namespace tern::proto {
namespace {

constexpr double normal_tolerance = 1e-6;
constexpr std::int64_t max_ticks = std::int64_t{1} << 53;  // beyond it a time is no longer exact in a double

/// The first of 0 ... count - 1 for which `holds` is false, or count. Every number that is sent or received passes here, so
/// blocks are judged without a branch per entry.
template <class Holds>
int first_that_fails(int count, Holds holds) {
  constexpr int block = 64;
  int begin = 0;
  for (; begin + block <= count; begin += block) {
    std::int64_t failures = 0;  // as wide as the numbers
    for (int i = begin; i < begin + block; ++i) failures += !holds(i);
    if (failures != 0) break;
  }
  while (begin < count && holds(begin)) ++begin;
  return begin;
}

/// Collects the first fault; later checks do nothing once there is one.
class Check {
 public:
  std::string fault;

  bool require(bool holds) const { return !fault.empty() || holds; }

  void length(const char* field, int found, std::size_t expected, const char* reason) {
    if (!require(static_cast<std::size_t>(found) == expected))
      fault = fmt::format("{} has {} entries; it must have {} ({})", field, found, expected, reason);
  }
  template <class Holds>
  void each(const char* field, const google::protobuf::RepeatedField<double>& values, Holds holds, const char* limit) {
    if (!fault.empty()) return;
    const double* value = values.data();
    const int i = first_that_fails(values.size(), [=](int k) { return std::isfinite(value[k]) & holds(value[k]); });
    if (i < values.size()) fault = fmt::format("{}[{}] is {}; it must be {}", field, i, value[i], limit);
  }
  void finite(const char* field, const google::protobuf::RepeatedField<double>& values) {
    each(
        field, values, [](double) { return true; }, "finite");
  }
  void positive(const char* field, const google::protobuf::RepeatedField<double>& values) {
    each(
        field, values, [](double v) { return v > 0; }, "finite and above 0");
  }
  /// Vectors of D components one after the other.
  template <int D>
  void unit(const char* field, const google::protobuf::RepeatedField<double>& vectors) {
    if (!fault.empty()) return;
    const double* component = vectors.data();
    const auto square_of = [=](int k) {
      double square = 0;
      for (int a = 0; a < D; ++a) square += component[D * k + a] * component[D * k + a];
      return square;
    };
    constexpr double shortest = 1 - normal_tolerance, longest = 1 + normal_tolerance;
    const auto of_length_one = [=](int k) {
      return (square_of(k) >= shortest * shortest) & (square_of(k) <= longest * longest);  // without a root each
    };
    const int points = vectors.size() / D;
    const int k = first_that_fails(points, of_length_one);
    if (k < points)
      fault = fmt::format("{} of point {} has length {}; it must be 1 to within {}", field, k, std::sqrt(square_of(k)), normal_tolerance);
  }
  void name_length(const char* field, const std::string& text) {
    if (!require(text.size() <= max_name_bytes))
      fault = fmt::format("{} has {} bytes; the limit is {}", field, text.size(), max_name_bytes);
  }
  void proposed_step(double seconds, const char* limit, bool holds) {
    if (!require(std::isfinite(seconds) && holds)) fault = fmt::format("proposed_step_s is {}; it must be {}", seconds, limit);
  }

  void account(const wire::Account& account, std::optional<std::size_t> energies, std::optional<std::size_t> gauges) {
    if (energies) length("account.energy", account.energy_size(), *energies, "as in Hello");
    if (gauges) length("account.gauge", account.gauge_size(), *gauges, "as in Hello");
    length("account.undefined", account.undefined_size(), static_cast<std::size_t>(account.gauge_size()), "one per gauge");
    finite("account.energy", account.energy());
    finite("account.gauge", account.gauge());
    for (int i = 0; fault.empty() && i < account.undefined_size(); ++i)
      if (account.undefined(i) && account.gauge(i) != 0)
        fault = fmt::format("account.gauge[{}] is {} although undefined; it must be 0", i, account.gauge(i));
  }

  void distinct(const char* field, const google::protobuf::RepeatedField<std::uint32_t>& labels) {
    if (!fault.empty() || labels.empty()) return;
    std::uint32_t least = labels[0], most = labels[0];
    for (const std::uint32_t label : labels) {
      least = std::min(least, label);
      most = std::max(most, label);
    }
    const std::size_t range = std::size_t{most} - least + 1;
    if (range <= 64 * static_cast<std::size_t>(labels.size())) {  // the rule: one bit for each label the run may have
      std::vector<std::uint64_t> seen(range / 64 + 1);
      for (const std::uint32_t label : labels) seen[(label - least) / 64] |= std::uint64_t{1} << (label - least) % 64;
      int different = 0;
      for (const std::uint64_t bits : seen) different += std::popcount(bits);
      if (different == labels.size()) return;
    }
    std::vector<std::uint32_t> sorted(labels.begin(), labels.end());
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) fault = fmt::format("{} {} appears twice; labels must be distinct", field, *twice);
  }
};

void check_hello(Check& check, const wire::Hello& hello, bool structure) {
  if (!check.require(hello.dimension() == 2 || hello.dimension() == 3))
    check.fault = fmt::format("dimension is {}; it must be 2 or 3", hello.dimension());
  check.name_length("case_hash", hello.case_hash());
  check.name_length("version", hello.version());
  check.name_length("limit", hello.limit());
  check.proposed_step(hello.proposed_step_s(), "finite and 0 or more", hello.proposed_step_s() >= 0);
  if (!check.require(hello.checkpoint_size() <= max_checkpoints))
    check.fault = fmt::format("checkpoint has {} entries; the limit is {}", hello.checkpoint_size(), max_checkpoints);
  for (const auto& checkpoint : hello.checkpoint()) check.name_length("checkpoint.hash", checkpoint.hash());
  check.account(hello.account(), std::nullopt, std::nullopt);
  const auto& surface = hello.surface();
  const auto points = static_cast<std::size_t>(surface.body_size());
  if (!check.require(structure || points == 0))
    check.fault = fmt::format("surface.body has {} entries; only the structure has surface points", points);
  if (!check.require(!structure || points > 0))
    check.fault = "surface.body has 0 entries; the structure must have at least one surface point";
  check.length("surface.section_mass", surface.section_mass_size(), points, "one per surface.body entry");
  check.length("surface.impedance", surface.impedance_size(), points, "one per surface.body entry");
  check.length("surface.least_mass", surface.least_mass_size(), points, "one per surface.body entry");
  check.positive("surface.section_mass", surface.section_mass());
  check.positive("surface.impedance", surface.impedance());
  check.positive("surface.least_mass", surface.least_mass());
}

void check_welcome(Check& check, const wire::Welcome& welcome, const Agreement& agreement) {
  check.name_length("version", welcome.version());
  if (!check.require(welcome.surface_points() > 0)) check.fault = "surface_points is 0; it must be at least 1";
  if (!check.require(!agreement.surface_points || *agreement.surface_points == welcome.surface_points()))
    check.fault =
        fmt::format("surface_points is {}; it must be {} as in the structure's Hello", welcome.surface_points(), *agreement.surface_points);
  if (!check.require(welcome.resume_ticks() >= 0 && welcome.resume_ticks() <= max_ticks))
    check.fault = fmt::format("resume_ticks is {}; it must be between 0 and 2^53", welcome.resume_ticks());
}

void check_begin_window(Check& check, const wire::BeginWindow& window, const Agreement& agreement) {
  if (!check.require(window.begin_ticks() >= 0 && window.begin_ticks() <= max_ticks))
    check.fault = fmt::format("begin_ticks is {}; it must be between 0 and 2^53", window.begin_ticks());
  if (!check.require(window.duration_ticks() > 0 && window.duration_ticks() <= max_ticks))
    check.fault = fmt::format("duration_ticks is {}; it must be between 1 and 2^53", window.duration_ticks());
  if (!check.require(!agreement.next_begin_ticks || window.begin_ticks() == *agreement.next_begin_ticks))
    check.fault =
        fmt::format("begin_ticks is {}; it must be {}, the end of the window before", window.begin_ticks(), *agreement.next_begin_ticks);
}

void check_surface(Check& check, const wire::Surface& surface, const Agreement& agreement, bool from_coupler) {
  const auto D = static_cast<std::size_t>(agreement.dimension);
  const bool out_of_reach = from_coupler && agreement.extent && surface.position_size() == 0;
  const auto points = out_of_reach ? 0 : agreement.surface_points.value_or(0);
  check.length("position", surface.position_size(), D * points, "dimension times surface points");
  check.length("velocity", surface.velocity_size(), D * points, "dimension times surface points");
  check.length("normal", surface.normal_size(), D * points, "dimension times surface points");
  check.length("area", surface.area_size(), points, "one per surface point");
  check.finite("position", surface.position());
  check.finite("velocity", surface.velocity());
  check.finite("normal", surface.normal());
  check.positive("area", surface.area());
  agreement.dimension == 2 ? check.unit<2>("normal", surface.normal()) : check.unit<3>("normal", surface.normal());
  const std::optional<std::size_t> none = 0;
  check.account(surface.account(), from_coupler ? none : agreement.energies, from_coupler ? none : agreement.gauges);
}

void check_interface_particles(Check& check, const wire::InterfaceParticles& sent, const Agreement& agreement) {
  const auto D = static_cast<std::size_t>(agreement.dimension);
  const auto particles = static_cast<std::size_t>(sent.id_size());
  check.length("position", sent.position_size(), D * particles, "dimension times id entries");
  check.length("velocity", sent.velocity_size(), D * particles, "dimension times id entries");
  check.length("mass", sent.mass_size(), particles, "one per id");
  check.length("volume", sent.volume_size(), particles, "one per id");
  check.length("divergence", sent.divergence_size(), sent.divergence_size() == 0 ? 0 : particles, "one per id, or none without VEM");
  if (!check.require(static_cast<std::size_t>(sent.image_of_size()) <= max_images * particles))
    check.fault = fmt::format("image_of has {} entries; the limit is {} per particle", sent.image_of_size(), max_images);
  check.length("image_position", sent.image_position_size(), D * static_cast<std::size_t>(sent.image_of_size()),
               "dimension times image_of entries");
  check.distinct("id", sent.id());
  check.finite("position", sent.position());
  check.finite("velocity", sent.velocity());
  check.positive("mass", sent.mass());
  check.positive("volume", sent.volume());
  check.finite("divergence", sent.divergence());
  check.finite("image_position", sent.image_position());
  for (int m = 0; check.fault.empty() && m < sent.image_of_size(); ++m)
    if (sent.image_of(m) >= particles)
      check.fault = fmt::format("image_of[{}] is {}, but {} particles were sent", m, sent.image_of(m), particles);
  const auto points = agreement.surface_points.value_or(0);
  for (int m = 0; check.fault.empty() && m < sent.covered_size(); ++m)
    if (sent.covered(m) >= points || (m > 0 && sent.covered(m) <= sent.covered(m - 1)))
      check.fault = fmt::format("covered[{}] is {}; it must be above the one before and below {}, the number of surface points", m,
                                sent.covered(m), points);
}

void check_extent(Check& check, const wire::Extent& extent, const Agreement& agreement) {
  const auto D = static_cast<std::size_t>(agreement.dimension);
  check.length("extent.low", extent.low_size(), D, "the dimension");
  check.length("extent.high", extent.high_size(), D, "the dimension");
  check.finite("extent.low", extent.low());
  check.finite("extent.high", extent.high());
  for (int c = 0; check.fault.empty() && c < extent.low_size(); ++c)
    if (extent.low(c) > extent.high(c))
      check.fault = fmt::format("extent.low[{}] is {}, above extent.high[{}] = {}", c, extent.low(c), c, extent.high(c));
  for (const auto& [field, value] : {std::pair{"largest_speed", extent.largest_speed()}, std::pair{"reach", extent.reach()}})
    if (!check.require(std::isfinite(value) && value >= 0))
      check.fault = fmt::format("extent.{} is {}; it must be finite and 0 or more", field, value);
}

/// Points and lumps: as many lumps for every point, each of which there is.
void check_response(Check& check, const wire::InterfaceCondition& load, std::size_t points) {
  const auto entries = static_cast<std::size_t>(load.lump_size()), lumps = static_cast<std::size_t>(load.lump_mass_size());
  if (!check.require(points > 0 ? entries % points == 0 : entries == 0))
    check.fault = fmt::format("lump has {} entries; it must have as many for each of the {} surface points", entries, points);
  check.length("share", load.share_size(), entries, "one per entry of lump");
  if (!check.require(lumps <= entries)) check.fault = fmt::format("lump_mass has {} entries; lump names at most {}", lumps, entries);
  for (int m = 0; check.fault.empty() && m < load.lump_size(); ++m)
    if (load.lump(m) >= lumps) check.fault = fmt::format("lump[{}] is {}, but {} masses of lumps were sent", m, load.lump(m), lumps);
  check.each(
      "share", load.share(), [](double v) { return v >= 0; }, "finite and 0 or more");
  check.positive("lump_mass", load.lump_mass());
}

void check_interface_condition(Check& check, const wire::InterfaceCondition& load, const Agreement& agreement) {
  const auto D = static_cast<std::size_t>(agreement.dimension);
  check.length("force", load.force_size(), D * agreement.interface_particles.value_or(0), "dimension times interface particles");
  check.length("reference_pressure", load.reference_pressure_size(), agreement.surface_points.value_or(0), "one per surface point");
  check_response(check, load, agreement.surface_points.value_or(0));
  check.length("surface_velocity", load.surface_velocity_size(), agreement.projected ? D * agreement.surface_points.value_or(0) : 0,
               agreement.projected ? "dimension times surface points" : "none in the first of a window");
  if (load.answered_change_size() > 0)
    check.length("answered_change", load.answered_change_size(), agreement.projected ? 0 : D * agreement.surface_points.value_or(0),
                 agreement.projected ? "none but in the first of a window" : "none, or dimension times surface points");
  check.finite("force", load.force());
  check.finite("answered_change", load.answered_change());
  check.finite("surface_velocity", load.surface_velocity());
  check.finite("reference_pressure", load.reference_pressure());
  if (!check.require(load.answer_tolerance() >= 0 && load.answer_tolerance() <= 1))
    check.fault = fmt::format("answer_tolerance is {}; it must be from 0 to 1", load.answer_tolerance());
}

void check_interface_pressure(Check& check, const wire::InterfacePressure& sent, const Agreement& agreement) {
  const auto particles = agreement.interface_particles.value_or(0);
  check.length("pressure", sent.pressure_size(), particles, "one per interface particle");
  check.length("velocity", sent.velocity_size(), static_cast<std::size_t>(agreement.dimension) * particles,
               "dimension times interface particles");
  check.finite("pressure", sent.pressure());
  check.finite("velocity", sent.velocity());
}

void check_vectors(Check& check, const char* field, const google::protobuf::RepeatedField<double>& vectors, int dimension,
                   std::optional<std::size_t> points, const char* reason) {
  check.length(field, vectors.size(), static_cast<std::size_t>(dimension) * points.value_or(0), reason);
  check.finite(field, vectors);
}

void check_abort(Check& check, const wire::Abort& abort) {
  const int code = abort.exit_code();
  if (!check.require((code >= 2 && code <= 5) || code == 130))
    check.fault = fmt::format("exit_code is {}; it must be 2, 3, 4, 5 or 130", code);
  if (!check.require(!abort.sentence().empty() && abort.sentence().size() <= max_sentence_bytes))
    check.fault = fmt::format("sentence has {} bytes; it must have 1 to {}", abort.sentence().size(), max_sentence_bytes);
  check.name_length("checkpoint.hash", abort.checkpoint().hash());
}

}  // namespace

void remember(const wire::Message& message, Agreement& agreement) {
  switch (message.body_case()) {
    case Kind::kHello: {
      const auto& hello = message.hello();
      agreement.dimension = static_cast<int>(hello.dimension());
      if (message.sender() == wire::STRUCTURE) agreement.surface_points = hello.surface().body_size();
      agreement.energies = hello.account().energy_size();
      agreement.gauges = hello.account().gauge_size();
      break;
    }
    case Kind::kWelcome:
      agreement.surface_points = message.welcome().surface_points();
      agreement.extent = message.welcome().extent();
      if (message.welcome().resume_step() > 0) agreement.next_begin_ticks = message.welcome().resume_ticks();
      break;
    case Kind::kBeginWindow:
      agreement.next_begin_ticks = message.begin_window().begin_ticks() + message.begin_window().duration_ticks();
      agreement.interface_particles.reset();
      break;
    case Kind::kInterfaceParticles:
      agreement.interface_particles = message.interface_particles().id_size();
      agreement.projected = false;
      break;
    case Kind::kInterfaceCondition: agreement.projected = true; break;
    case Kind::kWindowDone: agreement.extent = message.window_done().has_extent(); break;
    default: break;
  }
}

std::string parse(std::span<const std::byte> bytes, wire::Message& message) {
  if (bytes.size() > max_message_bytes)
    return fmt::format("{} bytes; the limit of one message is {} bytes", bytes.size(), max_message_bytes);
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return fmt::format("{} bytes that are not a message of proto/wire/tern.proto (truncated or foreign)", bytes.size());
  return {};
}

std::string find_envelope_fault(const wire::Message& message, const Envelope& envelope, std::initializer_list<Kind> expected) {
  const Kind kind = message.body_case();
  if (kind == Kind::kAbort) {
    if (message.sender() == envelope.sender) return {};
  } else if (message.protocol_version() != protocol_version) {
    return fmt::format("protocol_version is {}; this program speaks version {}", message.protocol_version(), protocol_version);
  }
  if (message.sender() != envelope.sender) return fmt::format("sender is {}; it must be {}", name(message.sender()), name(envelope.sender));
  if (message.sequence() != envelope.sequence)
    return fmt::format("sequence is {}; it must be {} (a message is missing, repeated or invented)", message.sequence(), envelope.sequence);
  const std::uint64_t step = envelope.step + (kind == Kind::kBeginWindow ? 1 : 0);
  if (message.step() != step) return fmt::format("step is {}; it must be {}", message.step(), step);
  if (kind == Kind::BODY_NOT_SET) return fmt::format("body is of no kind that protocol version {} knows", protocol_version);
  if (expected.size() != 0 && std::find(expected.begin(), expected.end(), kind) == expected.end()) {
    std::string wanted;
    for (const Kind k : expected) wanted += (wanted.empty() ? "" : " or ") + name(k);
    return fmt::format("body is {}; it must be {} now", name(kind), wanted);
  }
  return {};
}

std::string find_body_fault(const wire::Message& message, const Agreement& agreement) {
  Check check;
  switch (message.body_case()) {
    case Kind::kHello: check_hello(check, message.hello(), message.sender() == wire::STRUCTURE); break;
    case Kind::kWelcome: check_welcome(check, message.welcome(), agreement); break;
    case Kind::kBeginWindow: check_begin_window(check, message.begin_window(), agreement); break;
    case Kind::kSurface: check_surface(check, message.surface(), agreement, message.sender() == wire::COUPLER); break;
    case Kind::kInterfaceParticles: check_interface_particles(check, message.interface_particles(), agreement); break;
    case Kind::kInterfaceCondition: check_interface_condition(check, message.interface_condition(), agreement); break;
    case Kind::kInterfacePressure: check_interface_pressure(check, message.interface_pressure(), agreement); break;
    case Kind::kInterfaceForce:
      check_vectors(check, "force", message.interface_force().force(), agreement.dimension, agreement.interface_particles,
                    "dimension times interface particles");
      break;
    case Kind::kWindowDone: {
      const auto& done = message.window_done();
      check.proposed_step(done.proposed_step_s(), "finite and above 0", done.proposed_step_s() > 0);
      check.name_length("limit", done.limit());
      check.account(done.account(), agreement.energies, agreement.gauges);
      if (done.has_extent()) check_extent(check, done.extent(), agreement);
      break;
    }
    case Kind::kSurfaceVelocity:
      check_vectors(check, "velocity", message.surface_velocity().velocity(), agreement.dimension, agreement.surface_points,
                    "dimension times surface points");
      break;
    case Kind::kSurfaceLoad:
      check_vectors(check, "force", message.surface_load().force(), agreement.dimension, agreement.surface_points,
                    "dimension times surface points");
      break;
    case Kind::kFinish:
    case Kind::kSave: break;
    case Kind::kSaved: check.name_length("hash", message.saved().hash()); break;
    case Kind::kFinished: check.account(message.finished().account(), agreement.energies, agreement.gauges); break;
    case Kind::kAbort: check_abort(check, message.abort()); break;
    case Kind::BODY_NOT_SET: check.fault = "body is missing"; break;
  }
  return check.fault;
}

}  // namespace tern::proto
