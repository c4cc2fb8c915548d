#pragma once
// Rendered pictures kept on disk, so that a studio which was rendered once starts at once. A folder with one folder an
// entry, named after its key's digest:
//   <digest>/entry.json           the key's text, the number of act frames, the bytes of each camera's picture
//   <digest>/frame000000.pictures all cameras' pictures of one act frame, as the cameras send them, with check sums
//   <digest>/lock                 locked while in use; its age is that of the last use
// A frame is there wholly or not at all, whatever interrupts the writer, and any number of processes may share the
// folder. When room is needed the entries unused for longest go.
// Everything here throws std::system_error if the file system refuses.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "capture/base/unique_fd.h"
#include "simulator/studio/picture_key.h"

namespace rotunda::simulator {

// One picture a camera, as it sends it.
using PictureSet = std::vector<std::vector<std::uint8_t>>;

struct EntryShape {
  int frames = 0;
  std::vector<std::uint64_t> picture_bytes;  // one a camera
  std::uint64_t bytes() const;               // of the whole entry, nearly
};

// The pictures of one key; nobody removes them while it lives. Reading is safe from any number of threads.
class CacheEntry {
 public:
  const EntryShape& shape() const { return shape_; }
  bool has(int frame) const;  // there, and of the right size
  std::vector<int> missing() const;

  void write(int frame, const PictureSet& pictures);  // throws InvalidInput for pictures of another shape
  // Fills `picture`, which is as long as the camera's. False if the frame is not there or damaged; what is damaged is
  // removed.
  bool read(int frame, std::size_t camera, std::span<std::uint8_t> picture) const;
  // Asks the kernel to fetch the frame from disk, in one large read and without waiting; never fails.
  void announce(int frame) const;
  std::optional<PictureSet> read(int frame) const;
  std::optional<std::vector<PictureSet>> read() const;  // all frames

 private:
  friend class FrameCache;
  CacheEntry(std::filesystem::path folder, capture::UniqueFd lock, EntryShape shape);
  std::filesystem::path file_of(int frame) const;
  std::uint64_t offset_of(std::size_t camera) const;

  std::filesystem::path folder_;
  capture::UniqueFd lock_;
  EntryShape shape_;
};

class FrameCache {
 public:
  struct Options {
    std::filesystem::path folder = default_folder();
    std::uint64_t most_bytes = 20'000'000'000;
  };
  // $XDG_CACHE_HOME/rotunda/studio, else ~/.cache/rotunda/studio, else a folder for temporary files.
  static std::filesystem::path default_folder();

  explicit FrameCache(Options options);  // makes the folder

  // The entry of a key, if its shape is known here: frames may still be missing.
  std::optional<CacheEntry> find(const PictureKey& key);
  // The same, made if it is not there; first makes room for it. Throws InvalidInput if it can never fit, and
  // std::system_error (no space) if the disk is too full.
  CacheEntry open(const PictureKey& key, const EntryShape& shape);

  std::uint64_t bytes() const;  // of all entries

 private:
  void make_room(std::uint64_t bytes, const std::filesystem::path& except);

  Options options_;
};

}  // namespace rotunda::simulator
