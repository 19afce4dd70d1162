// The errors that cross a public boundary of voxcarve. Each names what went wrong, where, and what to do, in one line,
// and carries the exit code that the command line turns it into.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace voxcarve {

/// Exit codes of the program; they are part of its interface.
enum class ExitCode : int {
  kSuccess = 0,
  kUsage = 2,       ///< the command line or a parameter is wrong
  kBadInput = 3,    ///< a file or a model cannot be read or makes no sense
  kResource = 4,    ///< memory, disk or a limit
  kMethod = 5,      ///< a method could not treat this model
  kCancelled = 130  ///< stopped on request (Ctrl-C)
};

/// Base of every error below. `what()` is one line without a trailing full stop.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode exit_code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// A file or a model is unreadable, truncated, inconsistent or empty. Thrown by readers, models and `Method::run`.
class InputError : public Error {
 public:
  explicit InputError(const std::string& message) : Error(ExitCode::kBadInput, message) {}
  /// `where` is a line number or a byte offset, already worded: "line 12", "byte 80".
  InputError(std::string_view file, std::string_view where, std::string_view message);
};

/// A parameter is unknown, of the wrong type or out of range, or two of them contradict each other.
class ParameterError : public Error {
 public:
  explicit ParameterError(const std::string& message) : Error(ExitCode::kUsage, message) {}
};

/// A limit would be exceeded: thrown before the allocation, with the number of bytes needed, or when a write fails.
class ResourceError : public Error {
 public:
  explicit ResourceError(const std::string& message) : Error(ExitCode::kResource, message) {}
};

/// The method ran and cannot give a result for this model; the message says why.
class MethodFailure : public Error {
 public:
  explicit MethodFailure(const std::string& message) : Error(ExitCode::kMethod, message) {}
};

/// The run was cancelled through its stop token.
class Cancelled : public Error {
 public:
  Cancelled() : Error(ExitCode::kCancelled, "cancelled") {}
};

}  // namespace voxcarve
