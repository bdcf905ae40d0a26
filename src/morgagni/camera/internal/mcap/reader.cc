// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/mcap/reader.h"

#include <algorithm>
#include <optional>

#include <spdlog/fmt/fmt.h>
#include <zstd.h>

#include "morgagni/camera/internal/byte_io.h"
#include "morgagni/camera/internal/mcap/format.h"
#include "morgagni/camera/internal/mcap/input_file.h"

namespace mor::internal::mcap {
namespace {

constexpr std::uint64_t kMaxChunkBytes = 256U << 20U;
constexpr std::uint64_t kMaxAttachmentBytes = 64U << 20U;
/// Of a record that is read whole: schema, channel, message index.
constexpr std::uint64_t kMaxSmallRecordBytes = 64U << 20U;
/// 30 frames a second with five messages each: 18 hours.
constexpr std::size_t kMaxMessages = 10'000'000;
/// Times, sizes, CRC and the name of the compression.
constexpr std::uint64_t kMaxChunkHeadBytes = 8 + 8 + 8 + 4 + 4 + 16 + 8;

struct ChunkPlace {
  std::uint64_t at = 0;  ///< Of the packed bytes in the file.
  std::uint64_t packed_size = 0;
  std::uint64_t size = 0;
  std::uint32_t crc = 0;
  bool is_zstd = false;
  bool is_indexed = false;
};

struct AttachmentPlace {
  std::string name;
  std::uint64_t at = 0;  ///< Of the record's content.
  std::uint64_t size = 0;
};

std::string_view take_string(ByteReader& in) {
  return in.take_text(in.take<std::uint32_t>());
}

}  // namespace

struct Reader::Impl {
  explicit Impl(InputFile input) : file(std::move(input)) {}

  tl::unexpected<Error> bad(std::uint64_t at, std::string_view what) const {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{}: damaged at byte {}: {}", file.name(), at, what));
  }

  Result<void> scan();
  Result<void> take_record(Opcode opcode, std::uint64_t at, std::uint64_t size);
  Result<void> take_chunk_head(std::uint64_t at, std::uint64_t size);
  Result<void> take_attachment_head(std::uint64_t at, std::uint64_t size);
  Result<void> take_index(ByteReader& in, std::uint64_t at);
  bool take_definition(Opcode opcode, ByteReader& in);
  Result<void> look_through(std::uint32_t chunk);
  Result<std::span<const std::byte>> unpacked(std::uint32_t chunk);

  InputFile file;
  std::map<std::uint16_t, ChannelInfo> channels;
  std::vector<ChunkPlace> chunks;
  std::vector<AttachmentPlace> attachments;
  std::vector<MessageRef> messages;
  bool is_complete = false;

  std::optional<std::uint32_t> open_chunk;
  Bytes open_bytes;
};

Reader::Reader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;
Reader::~Reader() = default;

Result<Reader> Reader::open(const std::filesystem::path& path) {
  MOR_TRY(auto file, InputFile::open(path));
  auto impl = std::make_unique<Impl>(std::move(file));
  const auto magic = impl->file.read(0, std::min<std::uint64_t>(kMagic.size(), impl->file.size()));
  if (!magic || !std::ranges::equal(magic->span(), std::as_bytes(std::span(kMagic)))) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{}: is no MCAP recording", path.string()));
  }
  MOR_CHECK(impl->scan());
  return Reader(std::move(impl));
}

/// From head to head. A record that the file's end cuts off is as if it were not there.
Result<void> Reader::Impl::scan() {
  std::uint64_t at = kMagic.size();
  while (file.size() - at >= kRecordHeadBytes) {
    MOR_TRY(const auto head, file.read(at, kRecordHeadBytes));
    ByteReader in(head.span());
    const auto opcode = static_cast<Opcode>(in.take<std::uint8_t>());
    const auto size = in.take<std::uint64_t>();
    at += kRecordHeadBytes;
    if (size > file.size() - at) break;
    if (opcode == Opcode::kFooter) {
      is_complete = true;
      break;
    }
    MOR_CHECK(take_record(opcode, at, size));
    at += size;
  }
  // Without an index (cut off, or a stranger's), or with channels that stand inside: look into it.
  const bool all_known = std::ranges::all_of(
      messages, [this](const MessageRef& message) { return channels.contains(message.channel); });
  if (!all_known) messages.clear();
  for (std::uint32_t i = 0; i < chunks.size(); ++i) {
    // The last chunk of a file without an end: its index may be cut off in the middle.
    const bool is_cut_off = !is_complete && i + 1 == chunks.size();
    if (all_known && chunks[i].is_indexed && !is_cut_off) continue;
    std::erase_if(messages, [i](const MessageRef& message) { return message.chunk == i; });
    MOR_CHECK(look_through(i));
  }
  return {};
}

Result<void> Reader::Impl::take_record(Opcode opcode, std::uint64_t at, std::uint64_t size) {
  if (opcode == Opcode::kChunk) return take_chunk_head(at, size);
  if (opcode == Opcode::kAttachment) return take_attachment_head(at, size);
  if (opcode == Opcode::kMessage) {
    return bad(at, "a message outside of a chunk, which Morgagni does not read");
  }
  const bool is_definition = opcode == Opcode::kSchema || opcode == Opcode::kChannel;
  if (!is_definition && opcode != Opcode::kMessageIndex) return {};
  if (size > kMaxSmallRecordBytes) {
    return bad(at,
               fmt::format("a record of {} bytes, the limit is {}", size, kMaxSmallRecordBytes));
  }
  MOR_TRY(const auto bytes, file.read(at, size));
  ByteReader in(bytes.span());
  if (opcode == Opcode::kMessageIndex) return take_index(in, at);
  if (!take_definition(opcode, in)) return bad(at, "a schema or channel is cut short");
  return {};
}

/// Of the summary or of a second chunk, they say the same again.
bool Reader::Impl::take_definition(Opcode opcode, ByteReader& in) {
  const auto id = in.take<std::uint16_t>();
  if (opcode == Opcode::kSchema) {
    (void)take_string(in);  // Its name: what a topic has is known.
    return in.ok();
  }
  (void)in.take<std::uint16_t>();  // Its schema.
  ChannelInfo channel;
  channel.topic = take_string(in);
  channel.encoding = take_string(in);
  channels.emplace(id, std::move(channel));
  return in.ok();
}

Result<void> Reader::Impl::take_chunk_head(std::uint64_t at, std::uint64_t size) {
  MOR_TRY(const auto bytes, file.read(at, std::min(size, kMaxChunkHeadBytes)));
  ByteReader in(bytes.span());
  ChunkPlace chunk;
  (void)in.take_bytes(16);  // First and last time: the message index has them all.
  chunk.size = in.take<std::uint64_t>();
  chunk.crc = in.take<std::uint32_t>();
  const auto compression = take_string(in);
  chunk.packed_size = in.take<std::uint64_t>();
  chunk.at = at + in.position();
  if (!in.ok() || chunk.packed_size != size - in.position()) {
    return bad(at, "the chunk's lengths do not agree");
  }
  if (compression != "zstd" && !compression.empty()) {
    return bad(at, fmt::format("packed with '{}', Morgagni reads zstd only", compression));
  }
  if (chunk.size > kMaxChunkBytes) {
    return bad(at, fmt::format("a chunk of {} bytes, the limit is {}", chunk.size, kMaxChunkBytes));
  }
  chunk.is_zstd = !compression.empty();
  if (!chunk.is_zstd && chunk.size != chunk.packed_size) {
    return bad(at, "the chunk's lengths do not agree");
  }
  chunks.push_back(chunk);
  return {};
}

Result<void> Reader::Impl::take_attachment_head(std::uint64_t at, std::uint64_t size) {
  constexpr std::uint64_t kEnoughForTheName = 16 + 4 + 256;
  MOR_TRY(const auto bytes, file.read(at, std::min(size, kEnoughForTheName)));
  ByteReader in(bytes.span());
  (void)in.take_bytes(16);
  const auto name = take_string(in);
  // A longer name than that is none that we ask for.
  if (in.ok()) attachments.push_back({std::string(name), at, size});
  return {};
}

Result<void> Reader::Impl::take_index(ByteReader& in, std::uint64_t at) {
  if (chunks.empty()) return bad(at, "an index before the first chunk");
  const auto channel = in.take<std::uint16_t>();
  const auto count = in.take<std::uint32_t>() / 16;
  if (!in.ok() || in.left() != std::uint64_t{count} * 16) return bad(at, "an index is cut short");
  if (messages.size() + count > kMaxMessages) {
    return bad(at, fmt::format("more than {} messages", kMaxMessages));
  }
  chunks.back().is_indexed = true;
  const auto chunk = static_cast<std::uint32_t>(chunks.size() - 1);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto time_ns = in.take<std::uint64_t>();
    messages.push_back({time_ns, in.take<std::uint64_t>(), chunk, channel});
  }
  return {};
}

Result<void> Reader::Impl::look_through(std::uint32_t chunk) {
  MOR_TRY(const auto bytes, unpacked(chunk));
  const auto at = chunks[chunk].at;
  ByteReader in(bytes);
  while (in.left() > 0) {
    const auto offset = in.position();
    const auto opcode = static_cast<Opcode>(in.take<std::uint8_t>());
    const auto size = in.take<std::uint64_t>();
    ByteReader record(in.take_bytes(size));
    if (!in.ok()) return bad(at, "a record inside the chunk is cut short");
    if (opcode == Opcode::kSchema || opcode == Opcode::kChannel) {
      if (!take_definition(opcode, record)) return bad(at, "a schema or channel is cut short");
    } else if (opcode == Opcode::kMessage) {
      const auto channel = record.take<std::uint16_t>();
      (void)record.take<std::uint32_t>();
      const auto time_ns = record.take<std::uint64_t>();
      if (messages.size() >= kMaxMessages) {
        return bad(at, fmt::format("more than {} messages", kMaxMessages));
      }
      messages.push_back({time_ns, offset, chunk, channel});
    }
  }
  return {};
}

Result<std::span<const std::byte>> Reader::Impl::unpacked(std::uint32_t chunk) {
  if (open_chunk == chunk) return open_bytes.span();
  const auto& place = chunks[chunk];
  open_chunk.reset();
  MOR_TRY(auto packed, file.read(place.at, place.packed_size));
  if (!place.is_zstd) {
    open_bytes = std::move(packed);
  } else {
    const auto said = ZSTD_getFrameContentSize(packed.data.get(), packed.size);
    if (said == ZSTD_CONTENTSIZE_ERROR ||
        (said != ZSTD_CONTENTSIZE_UNKNOWN && said != place.size)) {
      return bad(place.at, "the chunk's lengths do not agree");
    }
    open_bytes = make_bytes(place.size);
    const auto size =
        ZSTD_decompress(open_bytes.data.get(), open_bytes.size, packed.data.get(), packed.size);
    if (ZSTD_isError(size) != 0 || size != place.size) {
      return bad(place.at, "the chunk cannot be unpacked");
    }
  }
  if (place.crc != 0 && crc32(open_bytes.span()) != place.crc) {
    return bad(place.at, "the chunk's check sum is wrong");
  }
  open_chunk = chunk;
  return open_bytes.span();
}

const std::map<std::uint16_t, ChannelInfo>& Reader::channels() const {
  return impl_->channels;
}
const std::vector<MessageRef>& Reader::messages() const {
  return impl_->messages;
}
bool Reader::is_complete() const {
  return impl_->is_complete;
}

Result<std::span<const std::byte>> Reader::read(const MessageRef& message) {
  MOR_TRY(const auto bytes, impl_->unpacked(message.chunk));
  ByteReader in(bytes);
  (void)in.take_bytes(message.offset);
  const auto opcode = static_cast<Opcode>(in.take<std::uint8_t>());
  ByteReader record(in.take_bytes(in.take<std::uint64_t>()));
  const auto channel = record.take<std::uint16_t>();
  (void)record.take<std::uint32_t>();
  const auto time_ns = record.take<std::uint64_t>();
  (void)record.take<std::uint64_t>();
  if (!in.ok() || !record.ok() || opcode != Opcode::kMessage || channel != message.channel ||
      time_ns != message.time_ns) {
    return impl_->bad(impl_->chunks[message.chunk].at, "the index does not lead to its message");
  }
  return record.take_bytes(record.left());
}

Result<std::vector<std::byte>> Reader::attachment(const std::string& name) {
  const auto place = std::ranges::find(impl_->attachments, name, &AttachmentPlace::name);
  if (place == impl_->attachments.end()) {
    return make_error(ErrorCode::kNotFound, fmt::format("{}: has no {}", impl_->file.name(), name));
  }
  if (place->size > kMaxAttachmentBytes) {
    return impl_->bad(
        place->at,
        fmt::format("{} of {} bytes, the limit is {}", name, place->size, kMaxAttachmentBytes));
  }
  MOR_TRY(const auto bytes, impl_->file.read(place->at, place->size));
  ByteReader in(bytes.span());
  (void)in.take_bytes(16);
  (void)take_string(in);
  (void)take_string(in);
  const auto data = in.take_bytes(in.take<std::uint64_t>());
  const auto covered = bytes.span().first(in.position());
  const auto crc = in.take<std::uint32_t>();
  if (!in.ok() || in.left() != 0) return impl_->bad(place->at, name + " is cut short");
  if (crc != 0 && crc32(covered) != crc) {
    return impl_->bad(place->at, fmt::format("the check sum of {} is wrong", name));
  }
  return std::vector(data.begin(), data.end());
}

}  // namespace mor::internal::mcap
