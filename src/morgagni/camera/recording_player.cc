// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <optional>

#include "morgagni/camera/internal/wait_until.h"
#include "morgagni/camera/recording.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::nanoseconds kFallbackPeriod{33'333'333};

class RecordingPlayer : public RangeCamera {
 public:
  RecordingPlayer(std::unique_ptr<const Recording> recording, const RecordingPlayerOptions& options)
      : recording_(std::move(recording)), options_(options) {}

  Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
    if (stop.stop_requested() || !has_frame()) return nullptr;
    const auto now = Clock::now();
    if (!started_at_) started_at_ = now;
    if (options_.is_real_time) {
      while (has_frame(next_ + 1) && due_at(next_ + 1) <= now) ++next_;
    }
    const auto due = due_at(next_);
    // Read ahead and handed over when it is due: reading pictures is no part of their age.
    const auto index = next_++ % recording_->size();
    MOR_TRY(const auto read, recording_->read(index));
    if (options_.is_real_time && !internal::wait_until(due, stop)) return nullptr;
    auto frame = std::make_shared<RgbdFrame>(*read);
    frame->captured_at = due;
    return frame;
  }

  const RgbdCalibration& calibration() const override { return *recording_->calibration(); }

 private:
  [[nodiscard]] bool has_frame() const { return has_frame(next_); }
  [[nodiscard]] bool has_frame(std::uint64_t i) const {
    return recording_->size() > 0 && (options_.is_looped || i < recording_->size());
  }

  /// The last frame of a round lasts as long as the mean of the others.
  [[nodiscard]] std::chrono::nanoseconds round() const {
    const auto size = recording_->size();
    if (size < 2) return kFallbackPeriod;
    const auto last = recording_->since_start(size - 1);
    return last + last / static_cast<std::int64_t>(size - 1);
  }

  [[nodiscard]] Clock::time_point due_at(std::uint64_t i) const {
    const auto num_rounds = static_cast<std::int64_t>(i / recording_->size());
    return *started_at_ + num_rounds * round() + recording_->since_start(i % recording_->size());
  }

  std::unique_ptr<const Recording> recording_;
  RecordingPlayerOptions options_;
  std::uint64_t next_ = 0;  ///< Counts on through the rounds of a loop.
  std::optional<Clock::time_point> started_at_;
};

}  // namespace

std::unique_ptr<RangeCamera> play_recording(std::unique_ptr<const Recording> recording,
                                            const RecordingPlayerOptions& options) {
  return std::make_unique<RecordingPlayer>(std::move(recording), options);
}

}  // namespace mor
