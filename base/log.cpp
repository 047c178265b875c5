// The log of one process, on spdlog's file sink.

#include "base/log.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <memory>

#include "base/error.hpp"

namespace tern {

namespace {

std::shared_ptr<spdlog::logger> logger;
std::string program = "tern";

void write(spdlog::level::level_enum level, const std::string& sentence) {
  if (logger) logger->log(level, spdlog::string_view_t(sentence));
}

}  // namespace

void set_log_program(const std::string& name) { program = name; }

void open_log(const std::string& out_dir, const std::string& role) {
  const std::string path = out_dir + "/" + role + ".log";
  try {
    auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path, true);
    logger = std::make_shared<spdlog::logger>(role, std::move(sink));
  } catch (const spdlog::spdlog_ex& error) {
    throw InputOutputError(fmt::format("Cannot write the log {}: {}; choose another --out.", path, error.what()));
  }
  logger->set_pattern("%Y-%m-%d %H:%M:%S.%e %l %v");
  logger->flush_on(spdlog::level::trace);
  // A full disk stops the run where results are lost; that the log misses lines is told once.
  logger->set_error_handler([path, told = false](const std::string& reason) mutable {
    if (!told) std::fprintf(stderr, "%s: warning: the log %s is incomplete: %s\n", program.c_str(), path.c_str(), reason.c_str());
    told = true;
  });
}

void log_info(const std::string& sentence) { write(spdlog::level::info, sentence); }

void log_warning(const std::string& sentence) {
  write(spdlog::level::warn, sentence);
  std::fprintf(stderr, "%s: warning: %s\n", program.c_str(), sentence.c_str());
}

void log_error(const std::string& sentence) {
  write(spdlog::level::err, sentence);
  std::fprintf(stderr, "%s: %s\n", program.c_str(), sentence.c_str());
}

void log_unsaid(const std::string& sentence) { write(spdlog::level::err, sentence); }

void close_log() noexcept {
  try {
    logger.reset();
  } catch (...) {}
}

}  // namespace tern
