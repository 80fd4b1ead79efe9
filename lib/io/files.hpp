#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace bayesctrl {

/// Files that appear together, each whole or not at all. `add` writes under a temporary name in the same folder, whose
/// parents it makes; `commit` brings all to the disk at once, then renames them in the order of their adding. A file
/// that stood there before keeps its content until its rename. Without `commit` the temporaries are removed; those of
/// processes that were killed go when another one first writes into their folder.
///
/// The flushes of a batch overlap on the disk: 20 files take about as long as one (3 ms where one by one take 80 ms).
class FileBatch {
 public:
  FileBatch() = default;
  FileBatch(const FileBatch&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  ~FileBatch();

  /// Throws IoError: full disk, read-only folder, a target that is not a regular file. The files added before stay.
  void add(const std::filesystem::path& path, std::string_view content);

  /// Throws IoError; files renamed before the failure stay.
  void commit();

 private:
  struct Pending {
    std::filesystem::path temporary;
    std::filesystem::path target;
  };
  void discard() noexcept;

  std::vector<Pending> pending_;
};

/// A batch of one. Throws IoError.
void write_file(const std::filesystem::path& path, std::string_view content);

/// Throws IoError where a file, which long work ends with, could not be written now: its name, what is there in its
/// place, or the rights of the nearest folder that exists. Makes nothing.
void require_writable(const std::filesystem::path& path);

/// A file that is read piece by piece. Throws IoError: it cannot be read, is a folder or a device, or a pipe into which
/// nothing is written.
class FileReader {
 public:
  explicit FileReader(std::filesystem::path path);
  FileReader(const FileReader&) = delete;
  FileReader& operator=(const FileReader&) = delete;
  ~FileReader();

  /// The next bytes, at most `size` of them; 0 at the end.
  std::size_t read(char* to, std::size_t size);
  /// Of a regular file; 0 of a pipe.
  std::uintmax_t bytes() const { return bytes_; }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  bool pipe_ = false;
  std::uintmax_t bytes_ = 0;
};

/// The whole file. Throws as FileReader does, DataError beyond `max_bytes`.
std::string read_file(const std::filesystem::path& path, std::size_t max_bytes);

/// A folder name for any text: letters, digits, '-', '_' and '.' stay, each run of others becomes one '-'; at most 100
/// bytes. Where anything was changed a hash of the text is appended, so that different texts get different names.
std::string slug(std::string_view name);

}  // namespace bayesctrl
