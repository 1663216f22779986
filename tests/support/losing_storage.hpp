// SPDX-License-Identifier: MIT
#pragma once
/// A file system in memory that knows what a power cut may take: whatever was not synced, in whole,
/// sector by sector, or out of order. A disk can be full, and its sync can fail. What a process
/// wrote and did not sync outlives the process (another opens the same storage), not the power.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "watersky/store/storage.hpp"

namespace watersky::test {

class LosingStorage final : public Storage {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Called before anything is done to the disk: the moments at which power may go.
  std::function<void()> before_each;
  std::atomic<std::uint64_t> capacity = UINT64_MAX;  ///< of all files together
  std::atomic<bool> syncs_fail = false;

  /// The disk as it may be found after a power cut now. Each write that was not synced is there,
  /// missing, torn, room filled with zeros, or there in some of its sectors, each by itself; each
  /// change of a name is there or missing.
  [[nodiscard]] std::unique_ptr<LosingStorage> after_power_cut(std::mt19937& random) const {
    auto out = std::make_unique<LosingStorage>();
    const auto chance = [&](int of) { return std::uniform_int_distribution(0, of - 1)(random); };
    // Sometimes the whole of it is there, or nothing: the ends of what may be.
    const int mood = chance(4);
    std::map<const Inode*, std::shared_ptr<Inode>> moved;
    const auto survived = [&](const std::shared_ptr<Inode>& inode) {
      auto& copy = moved[inode.get()];
      if (copy) return copy;
      copy = std::make_shared<Inode>();
      copy->durable = inode->durable;
      for (const Write& write : inode->pending) {
        const int fate = mood == 0 ? 0 : mood == 1 ? 1 : chance(5);
        if (fate == 1) continue;
        if (!write.is_cut && fate == 4) {
          write.apply_sectors(copy->durable, [&] { return chance(4) != 0; });
          continue;
        }
        Write kept = write;
        if (!write.is_cut && fate == 2)  // disks write whole sectors
          kept.bytes.resize(std::min<std::size_t>(
              kept.bytes.size(),
              kSectorBytes * static_cast<std::size_t>(
                                 chance(1 + static_cast<int>(kept.bytes.size() / kSectorBytes)))));
        if (!write.is_cut && fate == 3) std::fill(kept.bytes.begin(), kept.bytes.end(), 0);
        kept.apply(copy->durable);
      }
      copy->live = copy->durable;
      return copy;
    };
    std::map<std::string, std::shared_ptr<Inode>> names = durable_names_;
    for (const NameChange& change : pending_names_) {
      if (mood == 1 || (mood != 0 && chance(2) == 0)) continue;
      if (!change.gone.empty()) names.erase(change.gone);
      if (!change.made.empty()) names[change.made] = change.inode;
    }
    for (const auto& [name, inode] : names) out->names_[name] = survived(inode);
    out->durable_names_ = out->names_;
    out->folders_ = folders_;
    return out;
  }

  Result<std::unique_ptr<StorageFile>> open(const std::filesystem::path& path,
                                            FileAccess access) override {
    auto& inode = names_[path.string()];
    if (access == FileAccess::Create) {
      happen();
      // A new file, not the old one cut: what the old one held stays durable until this is.
      inode = std::make_shared<Inode>();
      pending_names_.push_back({"", path.string(), inode});
    }
    if (!inode) {
      names_.erase(path.string());
      return Error{ErrorCode::NotFound,
                   path.string() + ": cannot be opened: there is no such file"};
    }
    return std::unique_ptr<StorageFile>(std::make_unique<File>(*this, path, inode));
  }
  Result<std::vector<std::string>> list(const std::filesystem::path& folder) override {
    if (std::find(folders_.begin(), folders_.end(), folder) == folders_.end())
      return Error{ErrorCode::NotFound, folder.string() + ": cannot be listed: no such folder"};
    std::vector<std::string> out;
    for (const auto& [name, inode] : names_)
      if (std::filesystem::path(name).parent_path() == folder)
        out.push_back(std::filesystem::path(name).filename().string());
    return out;
  }
  Status make_folder(const std::filesystem::path& folder) override {
    folders_.push_back(folder);
    return {};
  }
  Status rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    happen();
    const auto found = names_.find(from.string());
    if (found == names_.end()) return Error{ErrorCode::NotFound, from.string() + ": is not there"};
    pending_names_.push_back({from.string(), to.string(), found->second});
    names_[to.string()] = found->second;
    names_.erase(from.string());
    return {};
  }
  Status remove(const std::filesystem::path& file) override {
    happen();
    pending_names_.push_back({file.string(), "", nullptr});
    return names_.erase(file.string()) == 1
               ? Status()
               : Status(Error{ErrorCode::NotFound, file.string() + ": is not there"});
  }
  Status sync_folder(const std::filesystem::path&) override {
    happen();
    durable_names_ = names_;
    pending_names_.clear();
    return {};
  }
  Result<std::unique_ptr<StorageLock>> lock(const std::filesystem::path&) override {
    return std::make_unique<StorageLock>();
  }

  /// The bytes of a file, to damage.
  [[nodiscard]] Bytes& bytes(const std::filesystem::path& file) {
    return names_.at(file.string())->live;
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const auto& [name, inode] : names_)
      out.push_back(std::filesystem::path(name).filename().string());
    return out;
  }

 private:
  static constexpr std::size_t kSectorBytes = 512;

  struct Write {
    std::uint64_t offset = 0;
    Bytes bytes;
    bool is_cut = false;
    void apply(Bytes& to) const {
      if (is_cut) return to.resize(offset);
      if (to.size() < offset + bytes.size()) to.resize(offset + bytes.size());
      std::copy(bytes.begin(), bytes.end(), to.begin() + static_cast<std::ptrdiff_t>(offset));
    }
    /// The file has grown by it, but a sector that `reached` says no to holds what it held before.
    template <typename Reached>
    void apply_sectors(Bytes& to, const Reached& reached) const {
      const std::uint64_t end = offset + bytes.size();
      if (to.size() < end) to.resize(end);
      for (std::uint64_t at = offset; at < end;) {
        const std::uint64_t next = std::min(end, (at / kSectorBytes + 1) * kSectorBytes);
        if (reached())
          std::copy(bytes.begin() + static_cast<std::ptrdiff_t>(at - offset),
                    bytes.begin() + static_cast<std::ptrdiff_t>(next - offset),
                    to.begin() + static_cast<std::ptrdiff_t>(at));
        at = next;
      }
    }
  };
  struct Inode {
    Bytes live, durable;
    std::vector<Write> pending;
  };
  struct NameChange {
    std::string gone, made;
    std::shared_ptr<Inode> inode;
  };

  class File final : public StorageFile {
   public:
    File(LosingStorage& storage, std::filesystem::path path, std::shared_ptr<Inode> inode)
        : storage_(storage), path_(std::move(path)), inode_(std::move(inode)) {}
    [[nodiscard]] const std::filesystem::path& path() const override { return path_; }
    [[nodiscard]] std::uint64_t size() const override { return inode_->live.size(); }
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
      if (offset > size() || into.size() > size() - offset)
        return Error{ErrorCode::OutOfRange, path_.string() + ": ends before"};
      std::copy_n(inode_->live.begin() + static_cast<std::ptrdiff_t>(offset), into.size(),
                  into.begin());
      return {};
    }
    Status append(std::span<const std::uint8_t> bytes) override {
      storage_.happen();
      const std::uint64_t all = storage_.capacity;
      const std::uint64_t room = all - std::min(all, storage_.used());
      const auto fits = static_cast<std::size_t>(std::min<std::uint64_t>(room, bytes.size()));
      const Write write{size(), Bytes(bytes.begin(), bytes.begin() + fits)};
      write.apply(inode_->live);
      inode_->pending.push_back(write);
      if (fits == bytes.size()) return {};
      return Error{ErrorCode::Io, path_.string() + ": cannot be written: No space left on device"};
    }
    Status truncate(std::uint64_t size) override {
      storage_.happen();
      const Write cut{size, {}, true};
      cut.apply(inode_->live);
      inode_->pending.push_back(cut);
      return {};
    }
    Status sync() override {
      storage_.happen();
      if (storage_.syncs_fail) {
        // As Linux does it: the pages count as clean from now on, and never reach the disk.
        inode_->pending.clear();
        return Error{ErrorCode::Io, path_.string() + ": cannot be brought to the disk: I/O error"};
      }
      // Only what is still waiting: pages that an earlier sync gave up are not written again.
      for (const Write& write : inode_->pending) write.apply(inode_->durable);
      inode_->pending.clear();
      return {};
    }

   private:
    LosingStorage& storage_;
    std::filesystem::path path_;
    std::shared_ptr<Inode> inode_;
  };

  void happen() const {
    if (before_each) before_each();
  }
  [[nodiscard]] std::uint64_t used() const {
    std::uint64_t sum = 0;
    for (const auto& [name, inode] : names_) sum += inode->live.size();
    return sum;
  }

  std::map<std::string, std::shared_ptr<Inode>> names_, durable_names_;
  std::vector<NameChange> pending_names_;
  std::vector<std::filesystem::path> folders_;
};

}  // namespace watersky::test
