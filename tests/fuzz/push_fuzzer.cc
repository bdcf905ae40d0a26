// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// What a device pushes: the first byte says whether it is a text, or a message of which kind and
// encoding; a picture is unpacked too.
#include <span>

#include "morgagni/camera/internal/push/client_channels.h"
#include "morgagni/camera/internal/push/messages.h"
#include "morgagni/camera/internal/push/picture_decoder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace push = mor::internal::push;
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data + 1, size - 1));
  if (data[0] >= 8) {
    push::ClientChannels channels;
    (void)channels.on_text({reinterpret_cast<const char*>(data + 1), size - 1});
    (void)channels.on_binary(bytes);
    return 0;
  }
  const auto message = push::parse_message(static_cast<push::MessageKind>(data[0] & 3U),
                                           static_cast<push::Encoding>(data[0] >> 2U),
                                           bytes);
  const auto* picture = message ? std::get_if<push::Picture>(&*message) : nullptr;
  if (picture == nullptr) return 0;
  (void)push::is_depth(*picture);
  (void)push::decode_depth_picture(*picture, {8, 6});
  (void)push::decode_color_picture(*picture, {8, 6});
  return 0;
}
