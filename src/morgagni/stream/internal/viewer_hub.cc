// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/viewer_hub.h"

#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/log.h"

namespace mor::internal {

std::string picture_message(const EncodedPicture& picture) {
  std::string message = fmt::format(
      R"({{"rtp":{},"captured_ms":{:.3f})", picture.rtp_stamp, server_ms(picture.captured_at));
  const std::string& own = picture.info_json;
  const auto first = own.find('{');
  const auto last = own.rfind('}');
  const bool has_members = first != std::string::npos && last != std::string::npos &&
                           own.find_first_not_of(" \t\r\n", first + 1) < last;
  if (has_members) message.append(",").append(own, first + 1, last - first - 1);
  return message.append("}");
}

ViewerHub::ViewerHub(MainLoop& main_loop, int max_viewers)
    : main_loop_(main_loop), max_viewers_(max_viewers) {}

ViewerHub::~ViewerHub() {
  remove_all();
}

void ViewerHub::set_encoder(VideoEncoder* encoder) {
  encoder_ = encoder;
}

bool ViewerHub::is_full() const {
  return viewers_.size() >= static_cast<std::size_t>(max_viewers_);
}

void ViewerHub::add(const std::string& offer_text, const Answered& answered) {
  auto offer = parse_offer(offer_text);
  if (!offer) {
    answered(tl::unexpected(offer.error()));
    return;
  }
  auto viewer = Viewer::create(
      main_loop_, encoder_->pipeline(), offer->vp8_payload_type, [encoder = encoder_] {
        encoder->request_key_picture();
      });
  if (!viewer) {
    answered(tl::unexpected(viewer.error()));
    return;
  }
  const GCharHandle id(g_uuid_string_random());
  viewers_[id.get()] = *viewer;
  publish();
  (*viewer)->answer(std::move(offer->sdp),
                    [answered, viewer_id = std::string(id.get())](Result<std::string> sdp) {
                      if (sdp) {
                        answered(Answer{viewer_id, *std::move(sdp)});
                      } else {
                        answered(tl::unexpected(sdp.error()));
                      }
                    });
}

bool ViewerHub::remove(const std::string& viewer_id) {
  auto node = viewers_.extract(viewer_id);
  if (node.empty()) return false;
  publish();
  node.mapped()->close();
  return true;
}

void ViewerHub::remove_all() {
  while (!viewers_.empty()) remove(std::string(viewers_.begin()->first));
}

void ViewerHub::remove_gone() {
  std::vector<std::string> gone;
  const auto now = Viewer::Clock::now();
  for (const auto& [id, viewer] : viewers_) {
    if (viewer->is_gone(now)) gone.push_back(id);
  }
  for (const auto& id : gone) {
    log::info("a viewer is gone without a word, {} left", viewers_.size() - 1);
    remove(id);
  }
}

void ViewerHub::publish() {
  std::vector<std::shared_ptr<Viewer>> list;
  for (const auto& [id, viewer] : viewers_) list.push_back(viewer);
  const std::lock_guard lock(mutex_);
  published_.swap(list);
}

void ViewerHub::send(const EncodedPicture& picture) {
  std::vector<std::shared_ptr<Viewer>> viewers;
  {
    const std::lock_guard lock(mutex_);
    viewers = published_;
  }
  if (viewers.empty()) return;
  const std::string message = picture_message(picture);
  for (const auto& viewer : viewers) viewer->send(picture, message);
}

int ViewerHub::num_viewers() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(published_.size());
}

}  // namespace mor::internal
