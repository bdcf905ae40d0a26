// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/usb_cameras.h"

#include <fstream>

#include <gmock/gmock.h>
#include <unistd.h>

namespace mor {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
namespace fs = std::filesystem;

/// A bus as the kernel shows it, made of files.
class UsbCameras : public testing::Test {
 protected:
  ~UsbCameras() override { fs::remove_all(home_); }

  void plug_in(const std::string& name,
               const std::string& vendor,
               const std::string& product,
               int number,
               const std::string& serial = {}) const {
    const auto folder = home_ / "sys" / name;
    fs::create_directories(folder);
    std::ofstream(folder / "idVendor") << vendor << "\n";
    std::ofstream(folder / "idProduct") << product << "\n";
    std::ofstream(folder / "busnum") << "2\n";
    std::ofstream(folder / "devnum") << number << "\n";
    if (!serial.empty()) std::ofstream(folder / "serial") << serial << "\n";
  }
  void allow(const std::string& number) const {
    fs::create_directories(home_ / "dev/002");
    std::ofstream(home_ / "dev/002" / number) << "";
  }
  std::vector<UsbCamera> list() const { return list_usb_cameras(home_ / "sys", home_ / "dev"); }

  const fs::path home_ = fs::temp_directory_path() / ("mor_usb_" + std::to_string(getpid()));
};

TEST_F(UsbCameras, KnowsThoseThatArePluggedInAndWhatOpensThem) {
  plug_in("2-1", "045e", "02ae", 7);
  allow("007");
  plug_in("2-2", "046d", "c52b", 8);  // A mouse.
  plug_in("2-3", "8086", "0b3a", 9);
  plug_in("2-4", "045e", "097c", 10);
  fs::create_directories(home_ / "sys/2-1:1.0");  // An interface has no vendor.
  const auto cameras = list();
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_EQ(cameras[1].product, "Azure Kinect");
  EXPECT_THAT(cameras[1].advice, HasSubstr("--camera push:"));
  EXPECT_EQ(cameras[0].product, "Kinect for Xbox 360");
  EXPECT_EQ(cameras[0].camera, "freenect:");
  EXPECT_TRUE(cameras[0].is_allowed);
  EXPECT_THAT(cameras[0].advice, IsEmpty());
  EXPECT_EQ(cameras[2].product, "RealSense D435i");
  EXPECT_THAT(cameras[2].advice, HasSubstr("push_realsense.py"));
}

TEST_F(UsbCameras, NamesADeviceAsItsDriverWillWhereTheBusTells) {
  plug_in("2-1", "045e", "02ae", 1, "A00366A08793039A");
  plug_in("2-2", "045e", "02bf", 2, "0000000000000000");
  plug_in("2-3", "1d27", "0601", 3, "1206120041");
  const auto cameras = list();
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_EQ(cameras[0].device_id, "freenect-A00366A08793039A");
  EXPECT_THAT(cameras[1].device_id, IsEmpty()) << "libfreenect asks the microphones";
  EXPECT_THAT(cameras[2].device_id, IsEmpty()) << "OpenNI2 has another number";
  plug_in("2-1", "045e", "02ae", 1, "000");
  EXPECT_THAT(list()[0].device_id, IsEmpty());
}

TEST_F(UsbCameras, SaysWhatToDoWhereThePermissionIsMissing) {
  plug_in("2-1", "045e", "02ae", 12);  // Without a file: as if it were not ours.
  ASSERT_EQ(list().size(), 1U);
  EXPECT_FALSE(list()[0].is_allowed);
  EXPECT_THAT(list()[0].advice, HasSubstr("60-morgagni-cameras.rules"));
}

TEST_F(UsbCameras, ABusThatIsNotThereOrNonsenseIsNoCamera) {
  EXPECT_THAT(list(), IsEmpty());
  plug_in("2-1", "1d27", "", 1);
  std::ofstream(home_ / "sys/2-1/busnum") << "none";
  ASSERT_EQ(list().size(), 1U);
  EXPECT_EQ(list()[0].camera, "openni2:") << "whatever its product";
  EXPECT_FALSE(list()[0].is_allowed);
}

}  // namespace
}  // namespace mor
