#include "io/files.hpp"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <set>

#include "io/examples.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;
using io_examples::error_of;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

std::string write_error(const fs::path& path) {
  return error_of<IoError>([&] { write_file(path, "new"); });
}

/// Files of this process cannot grow beyond `bytes`: the nearest that a test comes to a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit limit{.rlim_cur = bytes, .rlim_max = old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit old_{};
  void (*handler_)(int);
};

}  // namespace

TEST_CASE("a file is written whole, with its parent folders", "[io]") {
  const Folder folder;
  const fs::path path = folder.path() / "a" / "b" / "file.txt";
  write_file(path, "old");
  const std::string content(300'000, '\0');
  write_file(path, content);
  CHECK(read_file(path, 1'000'000) == content);
  CHECK(names_in(path.parent_path()) == std::set<std::string>{"file.txt"});
  write_file(path, "");
  CHECK(read_file(path, 0).empty());
  CHECK((fs::status(path).permissions() & fs::perms::owner_read) != fs::perms::none);
}

TEST_CASE("a failure says where and why", "[io]") {
  const Folder folder;
  write_file(folder.path() / "file", "x");
  const fs::path below = folder.path() / "file" / "inside" / "x.csv";
  CHECK(write_error(below) == below.string() + ": Not a directory");
  CHECK(write_error(folder.path()) == folder.path().string() + ": is there already and is not a regular file");
  CHECK(write_error("/dev/null") == "/dev/null: is there already and is not a regular file");
  CHECK_THAT(write_error("/proc/bayesctrl.txt"), Catch::StartsWith("/proc/bayesctrl.txt: "));
  CHECK(write_error("/proc/bayesctrl.txt") != "nothing thrown");
  const fs::path long_name = folder.path() / std::string(300, 'x');
  CHECK(write_error(long_name) == long_name.string() + ": File name too long");
  CHECK(names_in(folder.path()) == std::set<std::string>{"file"});
}

TEST_CASE("what cannot be written is known beforehand, and finding out leaves nothing", "[io]") {
  const Folder folder;
  write_file(folder.path() / "file", "x");
  const auto error = [](const fs::path& path) { return error_of<IoError>([&] { require_writable(path); }); };
  CHECK_THAT(error(folder.path() / "file" / "inside" / "x.csv"), Catch::EndsWith(": Not a directory"));
  CHECK_THAT(error(folder.path()), Catch::EndsWith(": is there already and is not a regular file"));
  CHECK_THAT(error(folder.path() / std::string(300, 'x') / "y"), Catch::EndsWith(": File name too long"));
  require_writable(folder.path() / "file");
  require_writable(folder.path() / "new" / "deep" / "x.csv");
  CHECK(names_in(folder.path()) == std::set<std::string>{"file"});
  CHECK(read_file(folder.path() / "file", 10) == "x");
}

TEST_CASE("a batch appears together or not at all", "[io]") {
  const Folder folder;
  const fs::path old = folder.path() / "old.txt";
  write_file(old, "old");
  {
    FileBatch batch;
    batch.add(old, "new");
    batch.add(folder.path() / "other.txt", "new");
    CHECK(read_file(old, 100) == "old");
    CHECK_FALSE(fs::exists(folder.path() / "other.txt"));
  }
  CHECK(names_in(folder.path()) == std::set<std::string>{"old.txt"});
  CHECK(read_file(old, 100) == "old");

  FileBatch batch;
  for (int i = 0; i < 50; ++i) batch.add(folder.path() / ("f" + std::to_string(i)), std::to_string(i));
  batch.commit();
  for (int i = 0; i < 50; ++i) CHECK(read_file(folder.path() / ("f" + std::to_string(i)), 10) == std::to_string(i));
  CHECK(names_in(folder.path()).size() == 51);
  batch.commit();
  CHECK(names_in(folder.path()).size() == 51);
}

TEST_CASE("a failing batch keeps what was there and leaves nothing behind", "[io]") {
  const Folder folder;
  const fs::path old = folder.path() / "old.txt";
  write_file(old, "old");
  {
    FileBatch batch;
    batch.add(old, "new");
    CHECK_THROWS_AS(batch.add(old / "below", "new"), IoError);
  }
  CHECK(names_in(folder.path()) == std::set<std::string>{"old.txt"});
  CHECK(read_file(old, 100) == "old");

  FileBatch blocked;
  blocked.add(folder.path() / "target", "new");
  blocked.add(old, "new");
  fs::create_directories(folder.path() / "target" / "occupied");  // in the way of the first rename
  CHECK(error_of<IoError>([&] { blocked.commit(); }) == (folder.path() / "target").string() + ": Is a directory");
  CHECK(read_file(old, 100) == "old");
  CHECK(names_in(folder.path()) == std::set<std::string>{"old.txt", "target"});
}

TEST_CASE("a write that fails midway keeps the old content and leaves nothing behind", "[io]") {
  const Folder folder;
  const fs::path path = folder.path() / "file";
  write_file(path, "old");
  std::string text;
  {
    const FileSizeLimit limit(100'000);
    text = error_of<IoError>([&] { write_file(path, std::string(200'000, 'x')); });
  }
  CHECK(text == path.string() + ": File too large");
  CHECK(read_file(path, 100) == "old");
  CHECK(names_in(folder.path()) == std::set<std::string>{"file"});
}

TEST_CASE("reading is bounded and says what failed", "[io]") {
  const Folder folder;
  const fs::path path = folder.path() / "file";
  write_file(path, "12345");
  CHECK(read_file(path, 5) == "12345");
  CHECK(error_of<DataError>([&] { read_file(path, 4); }) == path.string() + ": has more than 4 bytes");
  write_file(path, std::string(300'000, 'x'));
  CHECK(error_of<DataError>([&] { read_file(path, 100'000); }) == path.string() + ": has more than 100000 bytes");
  CHECK(error_of<IoError>([&] { read_file("/dev/zero", 100'000); }) == "/dev/zero: is a device, not a file");
  CHECK(error_of<IoError>([&] { read_file(folder.path(), 4); }) == folder.path().string() + ": Is a directory");
  CHECK(error_of<IoError>([&] { read_file("/nowhere/file", 4); }) == "/nowhere/file: No such file or directory");
}

TEST_CASE("any text becomes a folder name of its own", "[io]") {
  CHECK(slug("Exp1_gain-2.5") == "Exp1_gain-2.5");
  CHECK(slug(std::string(100, 'x')) == std::string(100, 'x'));
  CHECK_THAT(slug("<script>alert(1)</script>"), Catch::Matches("_script-alert-1-script--[0-9a-f]{8}"));
  std::set<std::string> slugs;
  const std::vector<std::string> names{"",
                                       ".",
                                       "..",
                                       "...",
                                       "/",
                                       "//",
                                       "a/b",
                                       "a\\b",
                                       "a b",
                                       "a  b",
                                       "../x",
                                       "-rf",
                                       "\xc3\xbc",
                                       "\xc3\xa4",
                                       "a\nb",
                                       std::string("a\0b", 3),
                                       std::string(101, 'x'),
                                       std::string(102, 'x'),
                                       std::string(100'000, '/'),
                                       ".hidden",
                                       "a*",
                                       "a?",
                                       "con:",
                                       "~",
                                       "$HOME"};
  for (const std::string& name : names) {
    const std::string result = slug(name);
    INFO(result);
    CHECK(!result.empty());
    CHECK(result.size() <= 100);
    CHECK(result.front() != '.');
    CHECK(result.front() != '-');
    CHECK(result.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.") ==
          std::string::npos);
    CHECK(slug(result) == result);
    CHECK(slugs.insert(result).second);
  }
}
