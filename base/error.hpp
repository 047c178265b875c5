#pragma once
// Errors a user can meet. Each class carries one exit code; what() is a full sentence with a remedy.

#include <stdexcept>
#include <string>

namespace tern {

/// Process exit codes; the launcher returns the code of the first cause.
enum class ExitCode : int {
  done = 0,
  bad_input = 2,
  numerical_failure = 3,
  peer_lost = 4,
  input_output = 5,
  interrupted = 130,
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ExitCode code() const { return code_; }
  /// Whether the same windows may go well at half their length.
  bool shorter_windows_may_help() const { return shorter_windows_may_help_; }

 protected:
  bool shorter_windows_may_help_ = false;

 private:
  ExitCode code_;
};

/// The case file, an option or a combination of them cannot be used.
struct BadInput : Error {
  explicit BadInput(const std::string& s) : Error(ExitCode::bad_input, s) {}
};
/// The computation left the range in which its result means something.
struct NumericalFailure : Error {
  explicit NumericalFailure(const std::string& s) : Error(ExitCode::numerical_failure, s) { shorter_windows_may_help_ = true; }
};
/// The scene has come to something that is not modelled, or asks for something that has no value: however short the windows.
struct EndOfModel : NumericalFailure {
  explicit EndOfModel(const std::string& s) : NumericalFailure(s) { shorter_windows_may_help_ = false; }
};
/// Another participant died, froze, fell silent or broke the protocol.
struct PeerLost : Error {
  explicit PeerLost(const std::string& s) : Error(ExitCode::peer_lost, s) {}
};
/// A file could not be read or written.
struct InputOutputError : Error {
  explicit InputOutputError(const std::string& s) : Error(ExitCode::input_output, s) {}
};
/// Ctrl-C or a termination signal; results up to here are kept.
struct Interrupted : Error {
  explicit Interrupted(const std::string& s) : Error(ExitCode::interrupted, s) {}
};

}  // namespace tern
