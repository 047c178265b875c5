#include "run/checkpoint.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/log.hpp"
#include "base/version.hpp"
#include "run/atomic_file.hpp"

namespace tern {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kept = 2;
constexpr std::size_t longest_manifest = 1 << 16;  // bytes

/// Steps of the files PREFIX.STEP.SUFFIX in a directory, newest first.
std::vector<std::uint64_t> steps_of(const std::string& directory, const std::string& prefix, const std::string& suffix) {
  std::vector<std::uint64_t> steps;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(prefix + ".") || !name.ends_with("." + suffix) || name.size() < prefix.size() + suffix.size() + 3) continue;
    const std::string digits = name.substr(prefix.size() + 1, name.size() - prefix.size() - suffix.size() - 2);
    if (digits.size() > 18 || digits.find_first_not_of("0123456789") != std::string::npos) continue;
    steps.push_back(std::stoull(digits));
  }
  std::sort(steps.rbegin(), steps.rend());
  return steps;
}

std::string name_of(const std::string& prefix, std::uint64_t step, const std::string& suffix) {
  return fmt::format("{}.{:09}.{}", prefix, step, suffix);
}

/// Empty when it cannot be read.
std::string hash_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return {};
  Hash hash;
  std::vector<char> piece(1 << 20);
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())), file.gcount() > 0)
    hash.add({piece.data(), static_cast<std::size_t>(file.gcount())});
  return file.bad() ? std::string() : hash.text();
}

Json to_json(const Manifest& manifest) {
  return {{"step", manifest.step},       {"time_s", manifest.time_s}, {"case", manifest.case_hash},
          {"program", manifest.program}, {"gauge", manifest.gauge},   {"hash", manifest.hash}};
}

std::optional<Manifest> read_manifest(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(longest_manifest, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  try {
    Json json = Json::parse(text);
    const std::string own = json.at("own").get<std::string>();
    json.erase("own");
    using Texts = std::map<std::string, std::string>;
    const Manifest manifest{json.at("step").get<std::uint64_t>(), json.at("time_s").get<double>(),       json.at("hash").get<Texts>(),
                            json.at("case").get<std::string>(),   json.at("program").get<std::string>(), json.at("gauge").get<Texts>()};
    if (hash_of(to_json(manifest).dump()) != own || json != to_json(manifest)) return std::nullopt;
    return manifest;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

std::string program_name() { return fmt::format("{} ({})", program_version, git_hash); }

CheckpointStore::CheckpointStore(const std::string& out_dir, std::string role, const Case& scene)
    : directory_(out_dir + "/checkpoint"), role_(std::move(role)), case_hash_(scene.hash_of_rest), gauge_hashes_(scene.gauge_hashes) {}

std::string CheckpointStore::path(std::uint64_t step) const { return directory_ + "/" + name_of(role_, step, "h5"); }
std::string CheckpointStore::temporary() const { return directory_ + "/" + role_ + ".h5.tmp"; }

void CheckpointStore::clear() const {
  std::error_code ignored;
  for (const std::uint64_t step : steps_of(directory_, role_, "h5")) fs::remove(path(step), ignored);
  for (const std::uint64_t step : steps_of(directory_, "manifest", "json"))
    fs::remove(directory_ + "/" + name_of("manifest", step, "json"), ignored);
  fs::remove(temporary(), ignored);
}

std::string CheckpointStore::write(std::uint64_t step, const StateWriter& state) const {
  std::error_code error;
  fs::create_directories(directory_, error);
  if (error) throw InputOutputError(fmt::format("Cannot create {}: {}.", directory_, error.message()));
  try {
    state.to_file(temporary());
  } catch (...) {
    fs::remove(temporary(), error);
    throw;
  }
  const std::string hash = hash_of_file(temporary());
  fs::rename(temporary(), path(step), error);
  if (error || hash.empty())
    throw InputOutputError(fmt::format("Cannot write {}: {}; free space or choose another --out.", path(step), error.message()));
  return hash;
}

std::string CheckpointStore::save(std::uint64_t step, const StateWriter& state) const {
  std::string hash = write(step, state);
  // Those of later steps, of a run that has gone back, count no longer.
  std::error_code error;
  std::size_t older = 0;
  for (const std::uint64_t other : steps_of(directory_, role_, "h5"))
    if (other > step || (other < step && ++older >= kept)) fs::remove(path(other), error);
  return hash;
}

std::vector<CheckpointFile> CheckpointStore::files() const {
  std::vector<CheckpointFile> files;
  for (const std::uint64_t step : steps_of(directory_, role_, "h5"))
    if (std::string hash = hash_of_file(path(step)); !hash.empty()) files.push_back({step, std::move(hash)});
  return files;
}

void CheckpointStore::write_manifest(Manifest manifest) const {
  manifest.case_hash = case_hash_;
  manifest.program = program_name();
  manifest.gauge = gauge_hashes_;
  Json json = to_json(manifest);
  json["own"] = hash_of(json.dump());
  write_atomically(directory_ + "/" + name_of("manifest", manifest.step, "json"), json.dump(1) + "\n");
  std::error_code ignored;
  std::size_t older = 0;
  for (const std::uint64_t other : steps_of(directory_, "manifest", "json"))
    if (other > manifest.step || (other < manifest.step && ++older >= kept))
      fs::remove(directory_ + "/" + name_of("manifest", other, "json"), ignored);
}

std::vector<Manifest> CheckpointStore::manifests() const {
  std::vector<Manifest> manifests;
  for (const std::uint64_t step : steps_of(directory_, "manifest", "json")) {
    const std::string file = directory_ + "/" + name_of("manifest", step, "json");
    if (auto manifest = read_manifest(file); manifest && manifest->step == step)
      manifests.push_back(std::move(*manifest));
    else
      log_warning(fmt::format("{} is not as it was written and does not count", file));
  }
  return manifests;
}

Manifest CheckpointStore::choose(const std::map<std::string, std::vector<CheckpointFile>>& offers) const {
  std::vector<std::string> missing;
  const auto all = manifests();
  for (const Manifest& manifest : all) {
    if (manifest.case_hash != case_hash_)
      throw BadInput(fmt::format(
          "The case is not the one of the checkpoints in {}: what was computed so far does not belong to it. Only "
          "end_time and the intervals of [output] may change, and gauges be added; undo the rest, or begin anew with ./tern run.",
          directory_));
    for (const auto& [name, hash] : manifest.gauge)
      if (const auto now = gauge_hashes_.find(name); now == gauge_hashes_.end() || now->second != hash)
        throw BadInput(
            fmt::format("The gauge '{}' {} since the checkpoints in {}; gauges may be added only: undo that, give the new one "
                        "another name, or begin anew with ./tern run.",
                        name, now == gauge_hashes_.end() ? "was removed" : "was changed", directory_));
    if (manifest.program != program_name())
      throw BadInput(
          fmt::format("The checkpoints in {} were written by tern {}, this is {}: continue with that version, or begin anew with "
                      "./tern run.",
                      directory_, manifest.program, program_name()));
    std::vector<std::string> without;
    for (const auto& [role, hash] : manifest.hash) {
      const auto offered = offers.find(role);
      const bool has =
          offered != offers.end() && std::any_of(offered->second.begin(), offered->second.end(),
                                                 [&, &h = hash](const auto& file) { return file.step == manifest.step && file.hash == h; });
      if (!has) without.push_back(role);
    }
    if (without.empty()) return manifest;
    missing.push_back(
        fmt::format("that of step {} lacks the file of the {}, or it was changed", manifest.step, fmt::join(without, " and the ")));
    log_warning(fmt::format("the checkpoint of step {} lacks the file of the {}, or it was changed", manifest.step,
                            fmt::join(without, " and the ")));
  }
  throw BadInput(fmt::format("There is no whole checkpoint in {}{}{}; begin anew with ./tern run.", directory_, missing.empty() ? "" : ": ",
                             fmt::join(missing, "; ")));
}

}  // namespace tern
