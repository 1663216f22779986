// SPDX-License-Identifier: MIT
#include "watersky/store/map_file.hpp"

#include <algorithm>
#include <tuple>

#include "watersky/store/detail/compression.hpp"
#include "watersky/store/detail/tile_record.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::FileKind;
using detail::IndexEntry;
using detail::Record;
using detail::RecordKind;

const char* const kRemedy =
    "; take another copy, or recover the tiles that are whole with watersky merge --recover";

auto key(const IndexEntry& e) { return std::tuple(e.level, e.index, e.source); }

Result<MapHeader> header_of(const Record& record, const StorageFile& file) {
  auto header =
      parse_header({reinterpret_cast<const char*>(record.payload.data()), record.payload.size()});
  if (!header) return header.error().at(file.path().string());
  return header;
}

/// A file whose records hold tiles; items keep it open.
class TilesOfFile final : public TileReader {
 public:
  TilesOfFile(std::unique_ptr<StorageFile> file, std::uint32_t salt)
      : file_(std::move(file)), salt_(salt) {}

  [[nodiscard]] const StorageFile& file() const { return *file_; }
  [[nodiscard]] std::string at(std::uint64_t place) const {
    return file_->path().string() + ": byte " + std::to_string(place);
  }
  [[nodiscard]] Result<Record> record(std::uint64_t place) const {
    auto record = detail::read_record(*file_, place, salt_);
    if (!record) return Error{record.error().code, record.error().message + kRemedy};
    return record;
  }
  [[nodiscard]] Result<PackedTile> packed(std::uint64_t place) const override {
    WATERSKY_TRY(const Record found, record(place));
    auto tile = detail::parse_tile_record(found);
    if (!tile) return tile.error().at(at(place));
    return std::move(tile->tile);
  }

 private:
  std::unique_ptr<StorageFile> file_;
  std::uint32_t salt_;
};

}  // namespace

class MapFile::Body {
 public:
  std::shared_ptr<const TilesOfFile> reader;
  MapHeader header;
  TileSet tiles;
  std::vector<IndexEntry> overviews;  ///< by level and tile
  std::vector<std::string> notes;

  Body(std::shared_ptr<const TilesOfFile> from, MapHeader described,
       const std::vector<IndexEntry>& entries)
      : reader(std::move(from)), header(std::move(described)) {
    std::vector<TileItem> items;
    for (const IndexEntry& e : entries)
      if (e.level == 0) {
        items.push_back({e.index, e.source, e.seen_cells, e.version, e.digest, reader, e.offset});
      } else {
        overviews.push_back(e);
      }
    tiles = TileSet(header.sources, std::move(items));
    std::sort(overviews.begin(), overviews.end(),
              [](const IndexEntry& a, const IndexEntry& b) { return key(a) < key(b); });
  }
};

Result<MapFile> MapFile::open(std::unique_ptr<StorageFile> file) {
  const std::string name = file->path().string();
  WATERSKY_TRY(const detail::Preamble preamble, detail::read_preamble(*file, FileKind::Map));
  auto reader = std::make_shared<const TilesOfFile>(std::move(file), preamble.salt);
  WATERSKY_TRY(const Record first, reader->record(detail::kPreambleBytes));
  WATERSKY_TRY(MapHeader header, header_of(first, reader->file()));
  WATERSKY_TRY(const std::uint64_t at, detail::read_footer(reader->file()));
  WATERSKY_TRY(const Record index, reader->record(at));
  auto entries = detail::parse_index(index);
  if (!entries) return entries.error().at(reader->at(at));
  for (const IndexEntry& e : *entries)
    if (e.source >= header.sources.size() && e.level == 0)
      return Error{
          ErrorCode::InvalidInput,
          reader->at(at) + ": the index names a source that the header does not" + kRemedy};
  return MapFile(std::make_shared<const Body>(std::move(reader), std::move(header), *entries));
}

Result<MapFile> MapFile::open(Storage& storage, const fs::path& path) {
  WATERSKY_TRY(std::unique_ptr<StorageFile> file, storage.open(path, FileAccess::Read));
  return open(std::move(file));
}

Result<MapFile> MapFile::recover(std::unique_ptr<StorageFile> file) {
  const std::string name = file->path().string();
  const auto preamble = detail::read_preamble(*file, FileKind::Map);
  if (!preamble && preamble.error().code == ErrorCode::Unsupported) return preamble.error();
  const std::optional<std::uint32_t> given =
      preamble ? std::optional(preamble->salt) : std::nullopt;
  auto record = detail::find_record(*file, 0, given);
  if (!record || record->kind != RecordKind::Header)
    return Error{ErrorCode::InvalidInput,
                 name +
                     ": its header is lost, so nobody knows where its cells lie; take another "
                     "copy"};
  WATERSKY_TRY(MapHeader header, header_of(*record, *file));
  const std::uint32_t salt = record->salt;
  std::vector<IndexEntry> entries;
  std::vector<std::string> notes;
  std::uint64_t expected = record->offset;
  std::size_t tiles = 0;
  for (; record; record = detail::find_record(*file, record->end(), salt)) {
    if (record->offset != expected)
      notes.push_back(name + ": bytes " + std::to_string(expected) + " to " +
                      std::to_string(record->offset) + " are damaged; what stood there is lost.");
    expected = record->end();
    if (record->kind == RecordKind::Tile) {
      const auto tile = detail::parse_tile_record(*record);
      if (!tile || tile->source >= header.sources.size()) continue;
      ++tiles;
      entries.push_back({.offset = record->offset,
                         .source = tile->source,
                         .level = 0,
                         .index = tile->index,
                         .seen_cells = tile->tile.seen_cells,
                         .version = tile->version,
                         .digest = tile->tile.digest});
    }
    // Overviews are left: they may show what is lost.
  }
  notes.push_back(name + ": " + std::to_string(tiles) + " whole tiles were found.");
  auto body = std::make_shared<Body>(std::make_shared<const TilesOfFile>(std::move(file), salt),
                                     std::move(header), entries);
  body->notes = std::move(notes);
  return MapFile(std::move(body));
}

const MapHeader& MapFile::header() const { return body_->header; }
const TileSet& MapFile::tiles() const { return body_->tiles; }
const std::vector<std::string>& MapFile::notes() const { return body_->notes; }
std::uint64_t MapFile::bytes() const { return body_->reader->file().size(); }
int MapFile::levels() const { return body_->overviews.empty() ? 0 : body_->overviews.back().level; }

std::vector<TileIndex> MapFile::overviews(int level) const {
  std::vector<TileIndex> out;
  for (const IndexEntry& e : body_->overviews)
    if (e.level == level) out.push_back(e.index);
  return out;
}

Result<std::optional<OverviewTile>> MapFile::overview(int level, const TileIndex& index) const {
  const auto found =
      std::lower_bound(body_->overviews.begin(), body_->overviews.end(), std::tuple(level, index),
                       [](const IndexEntry& e, const auto& wanted) {
                         return std::tuple(e.level, e.index) < wanted;
                       });
  if (found == body_->overviews.end() || found->level != level || found->index != index)
    return std::optional<OverviewTile>();
  WATERSKY_TRY(const Record record, body_->reader->record(found->offset));
  auto overview = detail::parse_overview_record(record);
  if (!overview) return overview.error().at(body_->reader->at(found->offset));
  return std::optional(std::move(overview->tile));
}

struct MapFileWriter::Body {
  Storage* storage = nullptr;
  fs::path path, part;
  std::unique_ptr<StorageFile> file;
  std::uint32_t salt = 0;
  std::size_t sources = 0;
  Bytes buffer;  ///< not yet written
  std::vector<IndexEntry> entries;
  bool finished = false;

  /// Where the next record will begin.
  [[nodiscard]] std::uint64_t end() const { return file->size() + buffer.size(); }

  Status flush(std::size_t above) {
    if (buffer.size() <= above) return {};
    WATERSKY_CHECK(file->append(buffer));
    buffer.clear();
    return {};
  }
  Status add(RecordKind kind, std::span<const std::uint8_t> payload) {
    constexpr std::size_t kBuffer = std::size_t{1} << 20;
    detail::append_record(buffer, kind, salt, payload);
    return flush(kBuffer);
  }
};

MapFileWriter::MapFileWriter(std::unique_ptr<Body> body) : body_(std::move(body)) {}
MapFileWriter::MapFileWriter(MapFileWriter&&) noexcept = default;
MapFileWriter::~MapFileWriter() {
  if (!body_ || body_->finished) return;
  body_->file.reset();
  if (const Status ignored = body_->storage->remove(body_->part); !ignored) return;
}

Result<MapFileWriter> MapFileWriter::begin(Storage& storage, const fs::path& path,
                                           const MapHeader& header) {
  auto body = std::make_unique<Body>();
  body->storage = &storage;
  body->path = path;
  body->part = path;
  body->part += ".part";
  body->salt = detail::new_salt();
  body->sources = header.sources.size();
  WATERSKY_TRY(body->file, storage.open(body->part, FileAccess::Create));
  body->buffer = detail::encode_preamble({FileKind::Map, body->salt});
  const std::string text = header_json(header);
  MapFileWriter writer(std::move(body));
  WATERSKY_CHECK(writer.body_->add(
      RecordKind::Header, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
  return writer;
}

Status MapFileWriter::add(std::size_t source, const TileIndex& index, std::uint64_t version,
                          const PackedTile& tile) {
  WATERSKY_REQUIRE(source < body_->sources);
  body_->entries.push_back({.offset = body_->end(),
                            .source = static_cast<std::uint32_t>(source),
                            .level = 0,
                            .index = index,
                            .seen_cells = tile.seen_cells,
                            .version = version,
                            .digest = tile.digest});
  return body_->add(
      RecordKind::Tile,
      detail::encode_tile_record(index, static_cast<std::uint32_t>(source), version, tile));
}

Status MapFileWriter::add_overview(int level, const TileIndex& index, const OverviewTile& tile) {
  WATERSKY_REQUIRE(level >= 1 && level <= detail::kMostLevel);
  body_->entries.push_back({.offset = body_->end(), .level = level, .index = index});
  return body_->add(RecordKind::Overview, detail::encode_overview_record(level, index, tile));
}

Status MapFileWriter::finish() {
  std::sort(body_->entries.begin(), body_->entries.end(),
            [](const IndexEntry& a, const IndexEntry& b) { return key(a) < key(b); });
  const std::uint64_t at = body_->end();
  WATERSKY_CHECK(body_->add(RecordKind::Index, detail::encode_index(body_->entries)));
  const Bytes footer = detail::encode_footer(at);
  body_->buffer.insert(body_->buffer.end(), footer.begin(), footer.end());
  WATERSKY_CHECK(body_->flush(0));
  WATERSKY_CHECK(body_->file->sync());
  WATERSKY_CHECK(body_->storage->rename(body_->part, body_->path));
  body_->finished = true;
  return body_->storage->sync_folder(body_->path.parent_path());
}

Status write_map_file(Storage& storage, const fs::path& path, const MapHeader& header,
                      const TileSet& tiles, const Progress& progress) {
  MapHeader described = header;
  described.sources = tiles.sources();
  WATERSKY_TRY(MapFileWriter writer, MapFileWriter::begin(storage, path, described));
  const MapViewParameters view = MapViewParameters::of(header);
  std::vector<TileIndex> order = tiles.tiles();
  const int levels = overview_levels(order);
  sort_for_overviews(order);
  Status written;
  OverviewStream overviews(levels, [&](int level, const TileIndex& index, const OverviewTile& t) {
    if (written.ok()) written = writer.add_overview(level, index, t);
  });
  std::size_t done = 0;
  for (const TileIndex& index : order) {
    report(progress, "write map", done++, order.size());
    std::vector<MapTile> sources;
    for (const TileItem& item : tiles.of(index)) {
      WATERSKY_TRY(const PackedTile packed, item.packed());
      WATERSKY_CHECK(writer.add(item.source, index, item.version, packed));
      WATERSKY_TRY(MapTile tile, unpack(packed));
      sources.push_back(std::move(tile));
    }
    overviews.add(index, overview_of(sum_of(sources, view), log_odds(view.prior)));
    WATERSKY_CHECK(written);
  }
  overviews.finish();
  WATERSKY_CHECK(written);
  return writer.finish();
}

}  // namespace watersky
