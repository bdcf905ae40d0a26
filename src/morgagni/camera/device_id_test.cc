// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/device_id.h"

#include <gmock/gmock.h>

namespace mor {
namespace {

using testing::HasSubstr;

TEST(DeviceId, IsWhatCanBeAFoldersName) {
  for (const char* id : {"a", "freenect-A00361D08047310A", "v4l2-usb-0000-00-14.0-2", "x_y."}) {
    EXPECT_TRUE(check_device_id(id)) << id;
  }
  for (const char* id : {"", ".", "..", ".a", "a/b", "a b", "\x1b[2J", "K\xc3\xb6ln"}) {
    EXPECT_THAT(check_device_id(id).error().message, HasSubstr("is no device's id")) << id;
  }
  EXPECT_TRUE(check_device_id(std::string(100, 'a')));
  EXPECT_FALSE(check_device_id(std::string(101, 'a')));
}

TEST(DeviceId, IsMadeOfWhatADriverSays) {
  EXPECT_EQ(plain_device_id("usb-0000:00:14.0-2"), "usb-0000-00-14.0-2");
  EXPECT_EQ(plain_device_id("../../etc"), "etc");
  EXPECT_EQ(plain_device_id(" 9044\n"), "9044");
  EXPECT_EQ(plain_device_id(""), "");
  EXPECT_EQ(plain_device_id("..."), "");
  EXPECT_TRUE(check_device_id(plain_device_id(std::string(500, 'z'))));
}

}  // namespace
}  // namespace mor
