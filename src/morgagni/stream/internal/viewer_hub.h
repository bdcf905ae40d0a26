// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "morgagni/stream/internal/viewer.h"

namespace mor::internal {

/// All viewers. They come and go in the main loop; pictures come from the encoder's thread.
class ViewerHub {
 public:
  struct Answer {
    std::string viewer_id;
    std::string sdp;
  };
  using Answered = std::function<void(Result<Answer>)>;

  ViewerHub(MainLoop& main_loop, int max_viewers);
  ~ViewerHub();
  ViewerHub(const ViewerHub&) = delete;
  ViewerHub& operator=(const ViewerHub&) = delete;

  /// The encoder is made after the hub, because it needs the hub to send to.
  void set_encoder(VideoEncoder* encoder);

  [[nodiscard]] bool is_full() const;

  /// Lets a browser in; `answered` is called once, later, in the main loop.
  void add(const std::string& offer, const Answered& answered);

  /// @return false: there is no such viewer.
  bool remove(const std::string& viewer_id);
  void remove_all();

  /// Removes those who vanished without a word. To be called about once a second.
  void remove_gone();

  /// Encoder's thread.
  void send(const EncodedPicture& picture);

  [[nodiscard]] int num_viewers() const;

 private:
  void publish();

  MainLoop& main_loop_;
  int max_viewers_;
  VideoEncoder* encoder_ = nullptr;
  std::map<std::string, std::shared_ptr<Viewer>> viewers_;

  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<Viewer>> published_;  ///< What the encoder's thread sees.
};

/// `{"rtp": stamp, "captured_ms": ..., <members of the picture's own object>}`
[[nodiscard]] std::string picture_message(const EncodedPicture& picture);

}  // namespace mor::internal
