// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/v4l2_camera.h"

#include <cerrno>
#include <cstring>
#include <deque>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>

#include <gmock/gmock.h>
#include <linux/videodev2.h>
#include <sys/mman.h>

#include "morgagni/camera/internal/v4l2/video_stream.h"
#include "morgagni/camera/watched_camera.h"
#include "morgagni/core/image_jpeg.h"

namespace mor {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Clock = std::chrono::steady_clock;

/// A video device of the pretended kernel, and all that can be wrong with it.
struct FakeDevice {
  std::string card = "Pretended Depth Camera";
  std::string bus = "usb-0000:00:14.0-2";
  std::uint32_t format = internal::kZ16;
  std::uint32_t width = 64, height = 48, row_bytes = 136;  // Rows longer than their pixels.
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  int open_error = 0;
  bool is_unplugged = false;
  bool is_silent = false;
  bool sends_short = false;   ///< Buffers that are not full.
  bool sends_errors = false;  ///< Buffers with the error flag.
  bool sends_eio = false;     ///< No buffer but EIO.
  bool sends_bad_index = false;
  bool writes_no_format = false;  ///< A driver that answers S_FMT with nonsense.
  int interrupts = 0;             ///< So many calls fail with EINTR first.
  std::vector<std::byte> picture;

  // What the kernel knows.
  bool is_open = false, is_streaming = false;
  int num_mapped = 0;
  std::vector<std::vector<std::byte>> buffers;
  std::deque<std::uint32_t> queue;
  Clock::time_point next_at = Clock::now();
};

/// A kernel in which each call does what the documentation of V4L2 says.
class FakeKernel : public internal::VideoSystem {
 public:
  explicit FakeKernel(std::map<std::string, FakeDevice> devices) : devices_(std::move(devices)) {}

  FakeDevice& device(const std::string& path) const { return devices_.at(path); }

  int open(const char* path) const override {
    const std::lock_guard lock(mutex_);
    const auto found = devices_.find(path);
    if (found == devices_.end() || found->second.is_unplugged) return fail(ENOENT);
    if (found->second.open_error != 0) return fail(found->second.open_error);
    if (found->second.is_open) return fail(EBUSY);
    found->second.is_open = true;
    const int file = 100 + static_cast<int>(files_.size());
    files_[file] = &found->second;
    return file;
  }
  int close(int file) const override {
    const std::lock_guard lock(mutex_);
    auto& device = *files_.at(file);
    EXPECT_TRUE(device.is_open);
    EXPECT_FALSE(device.is_streaming) << "closed while it streams";
    EXPECT_EQ(device.num_mapped, 0) << "closed while its buffers are mapped";
    device.is_open = false;
    device.queue.clear();
    return 0;
  }
  void* map(std::size_t size, int file, std::size_t offset) const override {
    const std::lock_guard lock(mutex_);
    auto& buffer = files_.at(file)->buffers.at(offset);
    EXPECT_EQ(size, buffer.size());
    ++files_.at(file)->num_mapped;
    return buffer.data();
  }
  int unmap(void* at, std::size_t) const override {
    const std::lock_guard lock(mutex_);
    for (auto& [path, device] : devices_) {
      for (const auto& buffer : device.buffers) device.num_mapped -= buffer.data() == at ? 1 : 0;
    }
    return 0;
  }
  int poll(pollfd* files, nfds_t count, int) const override {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const std::lock_guard lock(mutex_);
    int ready = 0;
    for (nfds_t i = 0; i < count; ++i) {
      const auto& device = *files_.at(files[i].fd);
      files[i].revents = device.is_unplugged ? POLLERR | POLLHUP : POLLIN;
      ++ready;
    }
    return ready;
  }
  int ioctl(int file, unsigned long request, void* argument) const override {
    const std::lock_guard lock(mutex_);
    auto& device = *files_.at(file);
    if (device.interrupts > 0) {
      --device.interrupts;
      return fail(EINTR);
    }
    if (device.is_unplugged && request != VIDIOC_STREAMOFF) return fail(ENODEV);
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto& capability = *static_cast<v4l2_capability*>(argument);
        std::strncpy(reinterpret_cast<char*>(capability.card), device.card.c_str(), 31);
        std::strncpy(reinterpret_cast<char*>(capability.bus_info), device.bus.c_str(), 31);
        capability.capabilities = device.capabilities;
        return 0;
      }
      case VIDIOC_ENUM_FMT: {
        auto& listed = *static_cast<v4l2_fmtdesc*>(argument);
        if (listed.index > 0) return fail(EINVAL);
        listed.pixelformat = device.format;
        return 0;
      }
      case VIDIOC_ENUM_FRAMESIZES: {
        auto& size = *static_cast<v4l2_frmsizeenum*>(argument);
        if (size.index > 1) return fail(EINVAL);
        size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
        size.discrete = {size.index == 0 ? 4000 : device.width,
                         size.index == 0 ? 4000 : device.height};
        return 0;
      }
      case VIDIOC_S_FMT: {
        auto& picture = static_cast<v4l2_format*>(argument)->fmt.pix;
        EXPECT_EQ(picture.width, device.width) << "the size that is nearest to 640x480";
        picture.bytesperline = device.writes_no_format ? 3 : device.row_bytes;
        return 0;
      }
      case VIDIOC_S_PARM:
        return fail(ENOTTY);
      case VIDIOC_REQBUFS: {
        auto& asked = *static_cast<v4l2_requestbuffers*>(argument);
        asked.count = 3;  // Fewer than asked for.
        device.buffers.assign(3,
                              std::vector<std::byte>(std::max<std::size_t>(
                                  device.picture.size(), device.row_bytes * device.height)));
        return 0;
      }
      case VIDIOC_QUERYBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        buffer.length = static_cast<std::uint32_t>(device.buffers.at(buffer.index).size());
        buffer.m.offset = buffer.index;
        return 0;
      }
      case VIDIOC_QBUF: {
        const auto index = static_cast<v4l2_buffer*>(argument)->index;
        EXPECT_EQ(std::ranges::count(device.queue, index), 0) << "queued twice";
        device.queue.push_back(index);
        return 0;
      }
      case VIDIOC_STREAMON:
        device.is_streaming = true;
        device.next_at = Clock::now();
        return 0;
      case VIDIOC_STREAMOFF:
        device.is_streaming = false;
        return 0;
      case VIDIOC_DQBUF:
        return dequeue(device, *static_cast<v4l2_buffer*>(argument));
      default:
        ADD_FAILURE() << "an ioctl that is not known: " << request;
        return fail(EINVAL);
    }
  }

 private:
  static int fail(int error) {
    errno = error;
    return -1;
  }

  static int dequeue(FakeDevice& device, v4l2_buffer& buffer) {
    const auto now = Clock::now();
    if (device.is_silent || device.queue.empty() || now < device.next_at) return fail(EAGAIN);
    device.next_at += std::chrono::milliseconds(10);
    if (device.sends_eio) return fail(EIO);
    const auto index = device.queue.front();
    device.queue.pop_front();
    auto& bytes = device.buffers[index];
    std::ranges::copy(device.picture, bytes.begin());
    buffer.index = device.sends_bad_index ? 77 : index;
    buffer.bytesused = static_cast<std::uint32_t>(
        device.sends_short
            ? bytes.size() / 2
            : (device.format == internal::kMjpg ? device.picture.size() : bytes.size()));
    buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC |
                   (device.sends_errors ? static_cast<unsigned>(V4L2_BUF_FLAG_ERROR) : 0U);
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch());
    buffer.timestamp = {us.count() / 1'000'000, us.count() % 1'000'000};
    return 0;
  }

  mutable std::mutex mutex_;
  mutable std::map<std::string, FakeDevice> devices_;
  mutable std::map<int, FakeDevice*> files_;
};

constexpr const char* kDepth = "/dev/video0";
constexpr const char* kColor = "/dev/video4";

FakeDevice depth_device() {
  FakeDevice device;
  device.picture.resize(device.row_bytes * device.height);
  for (std::uint32_t y = 0; y < device.height; ++y) {
    for (std::uint32_t x = 0; x < device.width; ++x) {
      const auto mm = static_cast<std::uint16_t>(x == 0 ? 0 : 500 + 10 * y + x);
      std::memcpy(device.picture.data() + y * device.row_bytes + 2 * x, &mm, 2);
    }
  }
  return device;
}

FakeDevice color_device(std::uint32_t format) {
  FakeDevice device;
  device.format = format;
  device.width = 32;
  device.height = 24;
  device.row_bytes = format == internal::kRgb3 ? 96 : 64;
  device.picture.assign(device.row_bytes * device.height, std::byte{128});  // Grey, in YUYV too.
  if (format == internal::kMjpg) {
    device.picture = encode_jpeg(Image<Rgb8>(32, 24, {130, 130, 130}).view(), 90).value();
  }
  return device;
}

class V4l2Test : public testing::Test {
 protected:
  Result<std::unique_ptr<RangeCamera>> open(bool with_color = false) const {
    return open_v4l2({.depth_device = kDepth, .color_device = with_color ? kColor : ""}, kernel_);
  }
  std::string refusal(bool with_color = false) const {
    const auto camera = open(with_color);
    return camera ? "opened" : camera.error().message;
  }
  FakeDevice& depth() const { return kernel_->device(kDepth); }
  FakeDevice& color() const { return kernel_->device(kColor); }

  std::shared_ptr<FakeKernel> kernel_ =
      std::make_shared<FakeKernel>(std::map<std::string, FakeDevice>{
          {kDepth, depth_device()}, {kColor, color_device(internal::kYuyv)}});
};

TEST_F(V4l2Test, GivesDepthToTheLastBitAndItInGreyWithoutColour) {
  const auto camera = open().value();
  const auto frame = camera->next_frame({}).value();
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->depth_mm.width(), 64);
  EXPECT_EQ(frame->depth_mm(0, 7), 0);
  EXPECT_EQ(frame->depth_mm(63, 47), 500 + 470 + 63);
  EXPECT_EQ(frame->color.width(), 64);
  EXPECT_EQ(frame->color(0, 7), Rgb8());
  EXPECT_GT(frame->color(9, 1).r, frame->color(9, 40).r) << "near is bright";
  EXPECT_LT(std::chrono::abs(Clock::now() - frame->captured_at), std::chrono::seconds(2));
  EXPECT_TRUE(frame->device_time);
  EXPECT_EQ(camera->next_frame({}).value()->frame_id, frame->frame_id + 1);
}

TEST_F(V4l2Test, PairsColourOfEachFormatWithDepth) {
  for (const auto format : {internal::kYuyv, internal::kMjpg, internal::kRgb3}) {
    color() = color_device(format);
    const auto camera = open(true).value();
    const auto frame = camera->next_frame({}).value();
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->color.width(), 32);
    EXPECT_NEAR(frame->color(9, 9).r, 130, 4) << format;
    EXPECT_NEAR(frame->color(9, 9).b, 130, 4) << format;
    EXPECT_EQ(frame->calibration->color.width_px, 32);
  }
}

TEST_F(V4l2Test, SaysWhyItCannotBeOpened) {
  depth().open_error = EACCES;
  EXPECT_THAT(refusal(), HasSubstr("may not use it"));
  depth().open_error = EBUSY;
  EXPECT_THAT(refusal(), HasSubstr("cannot be opened"));
  depth() = depth_device();
  depth().is_unplugged = true;
  EXPECT_THAT(refusal(), HasSubstr("there is no /dev/video0"));
  depth() = depth_device();
  depth().format = internal::kYuyv;
  EXPECT_THAT(refusal(), HasSubstr("has pictures of YUYV, Z16 is needed"));
  depth() = depth_device();
  depth().capabilities = V4L2_CAP_VIDEO_OUTPUT;
  EXPECT_THAT(refusal(), HasSubstr("gives no pictures"));
  depth() = depth_device();
  depth().writes_no_format = true;
  EXPECT_THAT(refusal(), HasSubstr("3 bytes a row"));
  depth() = depth_device();
  color().open_error = EACCES;
  EXPECT_THAT(refusal(true), HasSubstr(kColor));
  EXPECT_EQ(refusal(), "opened") << "what was opened before is closed";
}

TEST_F(V4l2Test, ASignalBetweenIsNoError) {
  depth().interrupts = 30;
  const auto camera = open().value();
  depth().interrupts = 5;
  EXPECT_TRUE(camera->next_frame({}).value());
}

TEST_F(V4l2Test, DamagedPicturesAreLeftOutAndSaid) {
  const auto camera = open().value();
  for (auto* damage : {&depth().sends_short, &depth().sends_errors, &depth().sends_eio}) {
    *damage = true;
    // What was good may still have waited.
    auto frame = camera->next_frame({});
    if (frame) frame = camera->next_frame({});
    EXPECT_THAT(frame.error().message, HasSubstr("damaged depth"));
    *damage = false;
    EXPECT_TRUE(camera->next_frame({}));
  }
}

TEST_F(V4l2Test, AnIndexThatIsNoneDoesNoHarm) {
  const auto camera = open().value();
  depth().sends_bad_index = true;
  for (int i = 0; i < 3; ++i) (void)camera->next_frame({});
}

TEST_F(V4l2Test, SaysWhenItIsSilentOrGone) {
  const auto camera = open(true).value();
  ASSERT_TRUE(camera->next_frame({}).value());
  color().is_silent = true;
  auto frame = camera->next_frame({});
  while (frame) frame = camera->next_frame({});
  EXPECT_THAT(frame.error().message,
              testing::AnyOf(HasSubstr("too far apart"), HasSubstr("no depth")));
  depth().is_silent = true;
  EXPECT_FALSE(camera->next_frame({}));
  depth().is_unplugged = true;
  EXPECT_THAT(camera->next_frame({}).error().message, HasSubstr("is gone"));
}

TEST_F(V4l2Test, EndsWhenAsked) {
  const auto camera = open().value();
  depth().is_silent = true;
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(camera->next_frame(stop.get_token()).value(), nullptr);
}

TEST_F(V4l2Test, BehindItsWatchItComesBackWhenItIsPluggedInAgain) {
  const auto camera = watch_camera([kernel = kernel_] {
                        return open_v4l2({.depth_device = kDepth, .color_device = kColor}, kernel);
                      }).value();
  ASSERT_TRUE(camera->next_frame({}).value());
  depth().is_unplugged = color().is_unplugged = true;
  const auto pulled_at = Clock::now();
  auto frame = camera->next_frame({});
  while (frame) frame = camera->next_frame({});
  EXPECT_LT(Clock::now() - pulled_at, std::chrono::milliseconds(1000));
  depth().is_unplugged = color().is_unplugged = false;
  const auto back_at = Clock::now();
  while (!frame || !*frame) frame = camera->next_frame({});
  EXPECT_LT(Clock::now() - back_at, std::chrono::seconds(3));
}

TEST_F(V4l2Test, AsksForWhatIsKnownOfItByItsSerialNumber) {
  const auto sysfs = std::filesystem::path(testing::TempDir()) / "mor_v4l2_sys";
  std::filesystem::remove_all(sysfs);
  std::filesystem::create_directories(sysfs / "usb/2-1/2-1:1.0");
  std::filesystem::create_directories(sysfs / "class/video0");
  std::filesystem::create_directory_symlink(sysfs / "usb/2-1/2-1:1.0",
                                            sysfs / "class/video0/device");
  V4l2Options options{.depth_device = kDepth, .sysfs = sysfs / "class"};
  options.known = [](const std::string& id, const RgbdCalibration& by_design) {
    auto known = by_design;
    known.depth.focal_x_px = id == "v4l2-904412060323" ? 41.5 : 0.0;
    return Result<std::optional<RgbdCalibration>>(known);
  };
  EXPECT_EQ(open_v4l2(options, kernel_).value()->device_id(), "v4l2-usb-0000-00-14.0-2")
      << "it has no number: where it is plugged in";
  depth().bus = "";
  EXPECT_EQ(open_v4l2(options, kernel_).value()->device_id(), "") << "nothing tells it apart";
  std::ofstream(sysfs / "usb/2-1/serial") << "904412060323\n";
  auto camera = open_v4l2(options, kernel_).value();
  EXPECT_EQ(camera->device_id(), "v4l2-904412060323");
  EXPECT_EQ(camera->calibration().depth.focal_x_px, 41.5);
  camera.reset();  // One at a time.
  options.device_id = "mine";
  EXPECT_EQ(open_v4l2(options, kernel_).value()->device_id(), "mine");
  std::filesystem::remove_all(sysfs);
}

TEST_F(V4l2Test, AreListedWithTheirColourOrWithAdvice) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "mor_v4l2_dev";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::map<std::string, FakeDevice> devices;
  for (const char* name : {"video0", "video2", "video4", "video10", "videonot", "null"}) {
    std::ofstream(folder / name);
    devices[folder / name] = color_device(internal::kYuyv);
  }
  devices[folder / "video2"] = depth_device();
  devices[folder / "video10"].open_error = EACCES;
  const auto found =
      list_depth_video_devices(folder, folder, std::make_shared<FakeKernel>(std::move(devices)));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].camera,
            "v4l2:" + (folder / "video2").string() + ",color=" + (folder / "video4").string());
  EXPECT_EQ(found[0].card, "Pretended Depth Camera");
  EXPECT_EQ(found[0].device_id, "v4l2-usb-0000-00-14.0-2");
  EXPECT_THAT(found[1].advice, HasSubstr("video $USER"));
  std::map<std::string, FakeDevice> late;
  late[folder / "video4"] = depth_device();
  late[folder / "video10"] = color_device(internal::kYuyv);
  EXPECT_EQ(list_depth_video_devices(folder, folder, std::make_shared<FakeKernel>(std::move(late)))
                .at(0)
                .camera,
            "v4l2:" + (folder / "video4").string() + ",color=" + (folder / "video10").string());
  EXPECT_THAT(list_depth_video_devices("/nowhere"), IsEmpty());
  std::filesystem::remove_all(folder);
}

TEST(V4l2Options, AreReadFromTheName) {
  const auto options =
      V4l2Options::parse("/dev/video2,color=/dev/video6,format=y16,device=bench").value();
  EXPECT_EQ(options.depth_device, "/dev/video2");
  EXPECT_EQ(options.color_device, "/dev/video6");
  EXPECT_TRUE(options.is_y16);
  EXPECT_EQ(options.device_id, "bench");
  EXPECT_THAT(V4l2Options::parse("").error().message, HasSubstr("needs a device"));
  EXPECT_THAT(V4l2Options::parse("/dev/video0,format=z17").error().message, HasSubstr("z16, y16"));
  EXPECT_THAT(V4l2Options::parse("/dev/video0,fps=9").error().message, HasSubstr("'fps'"));
}

}  // namespace
}  // namespace mor
