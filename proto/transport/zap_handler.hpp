#pragma once
// Decides who may connect to the coupler: answers the authentication requests (ZAP, rfc.zeromq.org/spec/27) of one context.
// There is no thread for it: requests wait until the owner of the socket looks for events. Both participants join while the
// coupler does nothing but look; whoever knocks while it computes is a stranger, and may wait.

#include <map>
#include <optional>
#include <string>

namespace tern::proto {

class ZapHandler {
 public:
  /// `allowed`: public key (Z85) -> role, which is attached to every message of that connection.
  ZapHandler(void* context, std::map<std::string, std::string> allowed);
  ~ZapHandler();
  ZapHandler(const ZapHandler&) = delete;
  ZapHandler& operator=(const ZapHandler&) = delete;

  /// Answers the requests that are there, up to the first one that is refused: returns address and key of that process.
  std::optional<std::string> answer();

  int descriptor() const;  ///< to wait for

 private:
  void* socket_;
  std::map<std::string, std::string> allowed_;
};

}  // namespace tern::proto
