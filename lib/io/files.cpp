#include "io/files.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdint>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include "base/error.hpp"

namespace bayesctrl {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const fs::path& path, int error) {
  throw IoError(path.string() + ": " + std::generic_category().message(error));
}

std::uint64_t hash_of(std::string_view text) {  // FNV-1a, 64 bits
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char letter : text) hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211ULL;
  return hash;
}

/// Names of temporaries are PREFIX HOST - PROCESS - NUMBER SUFFIX.
constexpr std::string_view kPrefix = ".bayesctrl-", kSuffix = ".tmp";
constexpr auto kForgotten = std::chrono::hours(24);  // age of another host's temporary that nobody writes any more

const std::string& this_host() {
  static const std::string name = [] {
    std::array<char, 256> host{};
    if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
    return std::to_string(hash_of(host.data()) >> 32);
  }();
  return name;
}

/// Whether the process that was writing a temporary is gone.
bool is_left_behind(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename().string();
  if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) return false;
  const std::string_view inside = std::string_view(name).substr(kPrefix.size());
  const std::size_t first = inside.find('-');
  const std::size_t second = first == std::string_view::npos ? first : inside.find('-', first + 1);
  if (second == std::string_view::npos) return false;
  pid_t process = 0;
  const std::string_view digits = inside.substr(first + 1, second - first - 1);
  if (std::from_chars(digits.data(), digits.data() + digits.size(), process).ec != std::errc{}) return false;
  if (inside.substr(0, first) == this_host()) return process > 0 && ::kill(process, 0) != 0 && errno == ESRCH;
  std::error_code error;
  const auto written = fs::last_write_time(entry.path(), error);
  return !error && fs::file_time_type::clock::now() - written > kForgotten;
}

/// Removes what processes that were killed left in a folder, when this process first writes there.
void sweep_up(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<fs::path> known;
  {
    const std::lock_guard lock(mutex);
    if (!known.insert(folder).second) return;
  }
  std::error_code error;
  std::vector<fs::path> dead;
  for (fs::directory_iterator it(folder.empty() ? "." : folder, error), end; !error && it != end; it.increment(error)) {
    if (is_left_behind(*it)) dead.push_back(it->path());
  }
  for (const fs::path& file : dead) ::unlink(file.c_str());
}

/// A new file with a name of its own in `folder`; O_EXCL settles races with other processes and hosts.
int create_temporary(const fs::path& folder, fs::path& name) {
  static std::atomic<unsigned> counter{0};
  sweep_up(folder);
  const std::string own = std::string(kPrefix) + this_host() + "-" + std::to_string(::getpid()) + "-";
  while (true) {
    name = folder / (own + std::to_string(counter++) + std::string(kSuffix));
    const int descriptor = ::open(name.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
  }
}

/// Writes and closes; returns errno, 0 when all went well. Some file systems report a full disk at `close` only.
int write_all(int descriptor, std::string_view content) {
  int error = 0;
  while (!content.empty() && error == 0) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written >= 0)
      content.remove_prefix(static_cast<std::size_t>(written));
    else if (errno != EINTR)
      error = errno;
  }
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

/// Waits until a pipe can be read or its other end is closed. Returns errno, ETIMEDOUT where nothing comes for long.
int await_pipe(int descriptor) {
  constexpr int kLongest = 10'000;  // ms
  pollfd waited{descriptor, POLLIN, 0};
  const int ready = ::poll(&waited, 1, kLongest);
  return ready > 0 ? 0 : ready == 0 ? ETIMEDOUT : errno;
}

/// Brings the file's content to the disk; returns errno. File systems that cannot do so answer EINVAL.
int sync_file(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  const int error = ::fdatasync(descriptor) != 0 && errno != EINVAL ? errno : 0;
  ::close(descriptor);
  return error;
}

/// Whether something stands at a path; throws IoError where that is not a regular file.
bool stands_as_file(const fs::path& path) {
  struct stat existing {};
  if (::stat(path.c_str(), &existing) != 0) return false;
  if (!S_ISREG(existing.st_mode)) throw IoError(path.string() + ": is there already and is not a regular file");
  return true;
}

void make_parents(const fs::path& path) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) fail(path, error.value());
}

/// Calls `sync(i)` for i < count on a few threads at once: the disk then serves them with a common flush.
void overlap(std::size_t count, const auto& sync) {
  constexpr std::size_t kThreads = 4;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) sync(i);
  };
  std::vector<std::jthread> threads;
  try {
    for (std::size_t i = 1; i < std::min(kThreads, count); ++i) threads.emplace_back(work);
  } catch (const std::system_error&) {  // no more threads to be had: fewer do the same work
  }
  work();
}

bool stays(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
}

}  // namespace

FileBatch::~FileBatch() { discard(); }

void FileBatch::discard() noexcept {
  for (const Pending& file : pending_) ::unlink(file.temporary.c_str());
  pending_.clear();
}

void FileBatch::add(const fs::path& path, std::string_view content) {
  stands_as_file(path);
  make_parents(path);
  Pending& file = pending_.emplace_back(Pending{.temporary = {}, .target = path});
  const int descriptor = create_temporary(path.parent_path(), file.temporary);
  const int error = descriptor < 0 ? errno : write_all(descriptor, content);
  if (error == 0) return;
  ::unlink(file.temporary.c_str());
  pending_.pop_back();
  fail(path, error);
}

void FileBatch::commit() {
  std::vector<int> errors(pending_.size(), 0);
  overlap(pending_.size(), [&](std::size_t i) { errors[i] = sync_file(pending_[i].temporary); });
  const auto refuse = [&](std::size_t i, int error) {
    const fs::path target = pending_[i].target;
    discard();
    fail(target, error);
  };
  for (std::size_t i = 0; i < pending_.size(); ++i) {
    if (errors[i] != 0) refuse(i, errors[i]);
  }
  for (std::size_t i = 0; i < pending_.size(); ++i) {
    if (::rename(pending_[i].temporary.c_str(), pending_[i].target.c_str()) != 0) refuse(i, errno);
  }
  pending_.clear();
}

void require_writable(const fs::path& path) {
  for (const fs::path& part : path) {
    if (part.native().size() > NAME_MAX) fail(path, ENAMETOOLONG);
  }
  if (!stands_as_file(path) && errno != ENOENT) fail(path, errno);
  struct stat existing {};
  fs::path folder = path.parent_path();  // the nearest that is there
  while (!folder.empty() && ::stat(folder.c_str(), &existing) != 0 && errno == ENOENT) folder = folder.parent_path();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) != 0) fail(path, errno);
}

void write_file(const fs::path& path, std::string_view content) {
  FileBatch batch;
  batch.add(path, content);
  batch.commit();
}

FileReader::FileReader(fs::path path) : path_(std::move(path)) {
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // no waiting for a pipe's writer
  struct stat kind {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &kind) != 0) {
    const int error = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    fail(path_, error);
  }
  if (S_ISCHR(kind.st_mode) || S_ISBLK(kind.st_mode)) {
    ::close(descriptor_);
    throw IoError(path_.string() + ": is a device, not a file");
  }
  pipe_ = S_ISFIFO(kind.st_mode);
  if (S_ISREG(kind.st_mode)) bytes_ = static_cast<std::uintmax_t>(kind.st_size);
}

FileReader::~FileReader() { ::close(descriptor_); }

std::size_t FileReader::read(char* to, std::size_t size) {
  while (true) {
    if (pipe_) {
      const int error = await_pipe(descriptor_);
      if (error == ETIMEDOUT) throw IoError(path_.string() + ": is a pipe into which nothing is written");
      if (error != 0) fail(path_, error);
    }
    const ssize_t count = ::read(descriptor_, to, size);
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno != EINTR && errno != EAGAIN) fail(path_, errno);
  }
}

std::string read_file(const fs::path& path, std::size_t max_bytes) {
  FileReader file(path);
  std::string content;
  const auto limit = [&] {
    if (content.size() > max_bytes || file.bytes() > max_bytes) {
      throw DataError({.file = path.string()}, "has more than " + std::to_string(max_bytes) + " bytes");
    }
  };
  limit();
  std::array<char, 65536> buffer{};
  while (const std::size_t count = file.read(buffer.data(), buffer.size())) {
    content.append(buffer.data(), count);
    limit();
  }
  return content;
}

std::string slug(std::string_view name) {
  constexpr std::size_t kLongest = 100;
  constexpr std::size_t kHashLength = 9;  // '-' and 8 hexadecimal digits
  std::string result;
  for (const char c : name) {
    if (stays(c))
      result += c;
    else if (result.empty() || result.back() != '-')
      result += '-';
  }
  if (result.starts_with('.') || result.starts_with('-')) result.front() = '_';  // hidden file; option of a command
  if (result == name && !result.empty() && result.size() <= kLongest) return result;
  result.resize(std::min(result.size(), kLongest - kHashLength));
  constexpr std::string_view kDigits = "0123456789abcdef";
  result += '-';
  for (std::uint64_t hash = hash_of(name) >> 32, i = 0; i < 8; ++i) result += kDigits[(hash >> (28 - 4 * i)) & 15];
  if (result.starts_with('-')) result.front() = '_';
  return result;
}

}  // namespace bayesctrl
