// Preloaded into one process of a run, does something terrible at an exact point of it: at the n-th message of a kind sent or
// received, when the socket is opened, or when a frame is written. What the others then do is what the test is about.
//
//   TERN_FAULT_PROCESS  base name of the program, or of the script it runs, e.g. tern-fluid
//   TERN_FAULT_AT       open | send:FIELD:N | receive:FIELD:N | frame:N    FIELD: number of the body in proto/wire/tern.proto
//   TERN_FAULT_DO       kill | stop | stuck | exit | full | nan | step | oversized | garbage    (the last four: of a message sent)

#include <dlfcn.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

namespace {

std::string action, place;
int field = 0, occurrence = 0, seen = 0;
bool disk_is_full = false;

std::string base_name(const std::string& path) { return path.substr(path.rfind('/') + 1); }

/// When the library is loaded.
const bool begun = [] {
  const char *process = std::getenv("TERN_FAULT_PROCESS"), *at = std::getenv("TERN_FAULT_AT"), *what = std::getenv("TERN_FAULT_DO");
  std::ifstream file("/proc/self/cmdline");
  bool meant = false;  // by its own name, or as the script of an interpreter with at most one option
  std::string word;
  for (int n = 0; process && n < 3 && std::getline(file, word, '\0'); ++n) meant = meant || base_name(word) == process;
  if (!meant || !at || !what) return false;
  action = what;
  char name[16] = {};
  if (std::sscanf(at, "%15[a-z]:%d:%d", name, &field, &occurrence) == 2) occurrence = field;  // frame:N
  place = name;
  return true;
}();

/// The next number of variable length; -1 at the end.
std::int64_t next(const unsigned char*& p, const unsigned char* end) {
  std::uint64_t value = 0;
  for (int shift = 0; p < end && shift < 64; shift += 7) {
    const unsigned char byte = *p++;
    value |= static_cast<std::uint64_t>(byte & 127) << shift;
    if (!(byte & 128)) return static_cast<std::int64_t>(value);
  }
  return -1;
}

struct Parts {
  int body = 0;                      ///< field number, 0: these bytes are no Message
  unsigned char* step = nullptr;     ///< where the number of the step is
  unsigned char* numbers = nullptr;  ///< where the first array of doubles in the body is
};

/// The account's field in the bodies that carry one after other fields: its energies are the numbers.
int account_of(int body) { return body == 10 ? 8 : body == 18 ? 4 : body == 21 ? 1 : 0; }

void find_numbers(unsigned char* data, std::int64_t size, int account, Parts& parts) {
  const unsigned char *p = data, *end = data + size;
  while (p < end && !parts.numbers) {
    const std::int64_t tag = next(p, end);
    if ((tag & 7) == 1) {  // a single double
      p += 8;
      continue;
    }
    const std::int64_t value = next(p, end);
    if (tag < 8 || ((tag & 7) != 0 && (tag & 7) != 2)) return;
    if ((tag & 7) == 0) continue;
    if (value < 0 || value > end - p) return;
    unsigned char* inside = data + (p - data);
    if (account != 0 && tag >> 3 == account) return find_numbers(inside, value, 0, parts);
    if (account == 0 && value >= 8 && value % 8 == 0) parts.numbers = inside;
    p += value;
  }
}

Parts parts_of(zmq_msg_t* message) {
  Parts parts;
  auto* data = static_cast<unsigned char*>(zmq_msg_data(message));
  const unsigned char *p = data, *end = data + zmq_msg_size(message);
  while (p < end) {
    const std::int64_t tag = next(p, end);
    if (tag < 8 || ((tag & 7) != 0 && (tag & 7) != 2)) return {};
    if (tag >> 3 == 4) parts.step = data + (p - data);
    const std::int64_t value = next(p, end);
    if (value < 0) return {};
    if ((tag & 7) == 0) continue;
    if (value > end - p) return {};
    if (tag >> 3 >= 10) {
      parts.body = static_cast<int>(tag >> 3);
      find_numbers(data + (p - data), value, account_of(parts.body), parts);
      return parts;
    }
    p += value;
  }
  return {};
}

void act() {
  if (action == "kill") raise(SIGKILL);
  if (action == "stop") raise(SIGSTOP);
  if (action == "exit") _exit(1);
  if (action == "full") disk_is_full = true;
  if (action == "stuck") {
    prctl(PR_SET_NAME, "stuck");  // for who looks at /proc
    for (;;) pause();             // the threads of ZeroMQ go on beating
  }
}

bool due(const char* where, int number) { return place == where && number == field && ++seen == occurrence; }

template <class Function>
Function* real(Function*, const char* name) {
  void* found = dlsym(RTLD_NEXT, name);
  // What an interpreter has loaded for one of its modules alone is not among the next ones.
  for (const char* library : {"libzmq.so.5", "libhdf5_serial.so.103"})
    if (void* handle = found ? nullptr : dlopen(library, RTLD_LAZY | RTLD_NOLOAD)) found = dlsym(handle, name);
  return reinterpret_cast<Function*>(found);
}

void open_socket(const char* address) {
  if (place == "open" && std::strncmp(address, "inproc", 6) != 0) act();
}

bool refused(int descriptor) {
  struct stat status;
  if (!disk_is_full || fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return false;
  errno = ENOSPC;
  return true;
}

}  // namespace

extern "C" {

int zmq_connect(void* socket, const char* address) {
  open_socket(address);
  return real(zmq_connect, "zmq_connect")(socket, address);
}

int zmq_bind(void* socket, const char* address) {
  open_socket(address);
  return real(zmq_bind, "zmq_bind")(socket, address);
}

int zmq_msg_send(zmq_msg_t* message, void* socket, int flags) {
  const Parts parts = action.empty() ? Parts{} : parts_of(message);
  if (due("send", parts.body)) {
    act();
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    if (action == "nan" && parts.numbers) std::memcpy(parts.numbers, &nan, sizeof(nan));
    if (action == "step" && parts.step) *parts.step ^= 1;
    if (action == "garbage") std::memset(zmq_msg_data(message), 0xff, zmq_msg_size(message));
    if (action == "oversized") {
      zmq_msg_close(message);
      zmq_msg_init_size(message, (256u << 20) + 1);
      std::memset(zmq_msg_data(message), 0, zmq_msg_size(message));
    }
  }
  return real(zmq_msg_send, "zmq_msg_send")(message, socket, flags);
}

int zmq_msg_recv(zmq_msg_t* message, void* socket, int flags) {
  const int size = real(zmq_msg_recv, "zmq_msg_recv")(message, socket, flags);
  if (!action.empty() && size > 0 && due("receive", parts_of(message).body)) act();
  return size;
}

// HDF5 opens its file anew for every frame; hid_t is an int64_t.
std::int64_t H5Fopen(const char* path, unsigned flags, std::int64_t access) {
  if (place == "frame" && ++seen == occurrence) act();
  return real(H5Fopen, "H5Fopen")(path, flags, access);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  return refused(descriptor) ? -1 : real(write, "write")(descriptor, bytes, size);
}

ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t offset) {
  return refused(descriptor) ? -1 : real(pwrite, "pwrite")(descriptor, bytes, size, offset);
}

ssize_t pwrite64(int descriptor, const void* bytes, size_t size, off64_t offset) {
  return refused(descriptor) ? -1 : real(pwrite64, "pwrite64")(descriptor, bytes, size, offset);
}

}  // extern "C"
