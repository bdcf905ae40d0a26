// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/tum_player.h"

#include <optional>

#include "morgagni/camera/internal/wait_until.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;

Clock::duration to_duration(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

class TumPlayer : public RangeCamera {
 public:
  TumPlayer(TumRecording recording, const TumPlayerOptions& options)
      : recording_(std::move(recording)), options_(options) {}

  Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
    if (stop.stop_requested() || !has_frame()) return nullptr;
    auto due = Clock::now();
    if (options_.is_real_time) {
      if (!started_at_) started_at_ = due;
      while (has_frame(next_ + 1) && due_at(next_ + 1) <= due) ++next_;
      due = due_at(next_);
    }
    // Read ahead and handed over when it is due: reading pictures is no part of their age.
    const auto index = next_++ % recording_.size();
    MOR_TRY(const auto read, recording_.read(index));
    if (options_.is_real_time && !internal::wait_until(due, stop)) return nullptr;
    auto frame = std::make_shared<RgbdFrame>(*read);
    frame->captured_at = due;
    return frame;
  }

  const RgbdCalibration& calibration() const override { return *recording_.calibration(); }

 private:
  [[nodiscard]] bool has_frame() const { return has_frame(next_); }
  [[nodiscard]] bool has_frame(std::uint64_t i) const {
    return options_.is_looped || i < recording_.size();
  }

  [[nodiscard]] double seconds_into(std::size_t i) const {
    return recording_.timestamp_s(i) - recording_.timestamp_s(0);
  }

  /// The last frame of a round lasts as long as the mean of the others.
  [[nodiscard]] double round_s() const {
    const auto size = recording_.size();
    if (size < 2) return 1.0 / 30.0;
    return seconds_into(size - 1) * static_cast<double>(size) / static_cast<double>(size - 1);
  }

  [[nodiscard]] Clock::time_point due_at(std::uint64_t i) const {
    const auto round = static_cast<double>(i / recording_.size());
    return *started_at_ + to_duration(round * round_s() + seconds_into(i % recording_.size()));
  }

  TumRecording recording_;
  TumPlayerOptions options_;
  std::uint64_t next_ = 0;  ///< Counts on through the rounds of a loop.
  std::optional<Clock::time_point> started_at_;
};

}  // namespace

std::unique_ptr<RangeCamera> play_recording(TumRecording recording,
                                            const TumPlayerOptions& options) {
  return std::make_unique<TumPlayer>(std::move(recording), options);
}

}  // namespace mor
