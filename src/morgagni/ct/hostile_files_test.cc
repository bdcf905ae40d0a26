// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Files that mean no good, or were met by a bad fate: each gets one sentence, nothing else.
#include <cstring>

#include <gmock/gmock.h>

#include "morgagni/ct/testing/dicom_writer.h"
#include "morgagni/ct/testing/import_folder.h"
#include "morgagni/ct/testing/sample_files.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_dicom;

struct BadFile {
  std::string name;
  std::string bytes;
  std::string sentence;  ///< A part of it.
};

class HostileFiles : public ImportFolder {
 protected:
  void expect_refused(const std::vector<BadFile>& files) {
    for (const auto& bad : files) {
      const auto path = write(bad.name, bad.bytes);
      EXPECT_THAT(error_of(path), AllOf(HasSubstr(bad.sentence), Not(HasSubstr(" died "))))
          << bad.name;
      fs::remove(path);
    }
  }
};

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

std::string mha(const std::string& lines, std::size_t num_bytes = 48) {
  return "ObjectType = Image\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" + lines +
         "ElementDataFile = LOCAL\n" + std::string(num_bytes, 'v');
}

TEST_F(HostileFiles, MetaImages) {
  const std::string size = "NDims = 3\nDimSize = 4 3 2\n";
  const std::string type = "ElementType = MET_SHORT\n";
  expect_refused({
      {"empty.mha", "", "damaged or not what its name says"},
      {"text.mha", "just some text", "damaged or not what its name says"},
      {"cut.mha",
       mha(size + type, 20),
       "cut short: 48 bytes of voxels are announced, 20 are there"},
      {"no_voxels.mha", mha(size + type, 0), "cut short"},
      {"flat.mha", mha("NDims = 2\nDimSize = 4 6\n" + type), "2 dimensions, a CT has 3"},
      {"moving.mha", mha("NDims = 4\nDimSize = 2 2 3 2\n" + type), "4 dimensions, a CT has 3"},
      {"colour.mha",
       mha(size + "ElementNumberOfChannels = 3\nElementType = MET_UCHAR\n", 72),
       "colour"},
      {"minus_dimensions.mha",
       mha("NDims = -13\nDimSize = 4 3 2\n" + type),
       "has -13 dimensions, a CT has 3"},
      {"long_key.mha",
       mha(std::string(260, 'K') + " = 1\n" + size + type),
       "damaged or not what its name says"},
      {"packed_minus.mha",
       mha("CompressedData = Tru\nCompressedDataSize = -44\n" + size + type),
       "cut short"},
      {"minus_after_nothing.mha",
       mha(std::string("NDims\0= -13\nDimSize = 4 3 2\n", 28) + type),
       "damaged or not what its name says"},
      {"minus_with_colon.mha",
       mha("NDims: -13\nDimSize = 4 3 2\n" + type),
       "has -13 dimensions, a CT has 3"},
      {"thin.mha", mha("NDims = 3\nDimSize = 24 1 1\n" + type), "1 voxels along y"},
      {"zero.mha", mha("NDims = 3\nDimSize = 4 0 2\n" + type), "0 voxels along"},
      {"minus.mha", mha("NDims = 3\nDimSize = 4 -3 2\n" + type), "voxels along"},
      {"huge_side.mha", mha("NDims = 3\nDimSize = 4 3 99999\n" + type), "99999 voxels along"},
      {"huge.mha", mha("NDims = 3\nDimSize = 2000 2000 2000\n" + type), "the limit is 2048 MiB"},
      {"lying.mha",
       mha("NDims = 3\nDimSize = 1000 1000 900\n" + type),
       "announces 1800000000 bytes"},
      {"no_spacing.mha", mha(size + type + "ElementSpacing = 0 1 1\n"), "spacing"},
      {"nan_spacing.mha", mha(size + type + "ElementSpacing = nan 1 1\n"), "spacing"},
      {"wide.mha",
       mha(size + type + "ElementSpacing = 1 1 4000\n"),
       "must be between 0.01 and 50 mm"},
      {"skew.mha", mha(size + type + "TransformMatrix = 1 0.4 0 0 1 0 0 0 1\n"), "right angles"},
      {"far.mha", mha(size + type + "Offset = 1e9 0 0\n"), "within 100 m"},
      {"other_file.mhd",
       "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
       "ElementDataFile = gone.raw\n",
       "cut short: 48 bytes of voxels are announced, 0 are there"},
      {"list.mhd", size + type + "ElementDataFile = LIST\none.raw\ntwo.raw\n", "in several files"},
      {"pattern.mhd", size + type + "ElementDataFile = LOCA%%%d 1 2 0\n", "in several files"},
      {"twice.mha", mha("NDims = 4\n" + size + type), "says NDims twice"},
      {"no_times.mha", mha("NDims = 4\nDimSize = 4 3 2 0\n" + type), "4 dimensions, a CT has 3"},
      {"nan.mha",
       mha(size + "ElementType = MET_FLOAT\n", 0) + repeated(std::string("\0\0\xc0\x7f", 4), 24),
       "a voxel that is not a number (voxel 0)"},
  });
}

/// An archive with one entry that claims 128 MiB of compressed bytes.
std::string lying_zip() {
  using namespace std::string_literals;
  const std::string method_time_and_sum = "\x08\0\0\0\0\0\0\0\0\0"s;
  const std::string sizes = "\0\0\0\x08\0\0\0\x10"s;
  const std::string name_length = "\x01\0\0\0"s;
  const std::string entry =
      "PK\x03\x04\x14\0\0\0"s + method_time_and_sum + sizes + name_length + "a";
  const std::string directory = "PK\x01\x02\x14\0\x14\0\0\0"s + method_time_and_sum + sizes +
                                name_length + std::string(14, '\0') + "a";
  const auto byte = [](std::size_t size) { return std::string(1, static_cast<char>(size)); };
  return entry + directory + "PK\x05\x06\0\0\0\0\x01\0\x01\0"s + byte(directory.size()) +
         std::string(3, '\0') + byte(entry.size()) + std::string(5, '\0');
}

TEST_F(HostileFiles, Nrrds) {
  const std::string head = "NRRD0004\ntype: short\nencoding: raw\nendian: little\n";
  const std::string grid = "dimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\n";
  expect_refused({
      {"empty.nrrd", "", "damaged"},
      {"magic.nrrd", "NRRD0004\n", "cut short, or its header"},
      {"other.nrrd", "PNG is not what this is", "damaged"},
      {"cut.nrrd",
       head + grid + "\n" + std::string(30, 'v'),
       "cut short: 48 bytes of voxels are announced, 30 are there"},
      {"no_size.nrrd",
       head + "dimension: 3\n\n" + std::string(48, 'v'),
       "its head has no line \"sizes:\""},
      {"minus.nrrd",
       head + "dimension: 3\nsizes: 4 -3 2\n\n" + std::string(48, 'v'),
       "has -3 voxels along y, the limits are 2 and 2048"},
      {"odd_size.nrrd",
       head + "dimension: 3\nsizes: 4 3c 2\n\n" + std::string(48, 'v'),
       "one of its sizes is \"3c\", which is no whole number"},
      {"two_sizes.nrrd",
       head + "dimension: 3\nsizes: 4 6\n\n" + std::string(48, 'v'),
       "its head has 2 sizes for 3 dimensions"},
      {"sixteen.nrrd",
       head + "dimension: 16\nsizes: 1 1 1 1 1 1 1 1 1 1 1 1 1 2 3 4\n\n" + std::string(48, 'v'),
       "16 dimensions, a CT has 3"},
      {"four.nrrd",
       head + "dimension: 4\nsizes: 2 3 2 2\n\n" + std::string(48, 'v'),
       "4 dimensions"},
      {"flat.nrrd", head + "dimension: 2\nsizes: 6 4\n\n" + std::string(48, 'v'), "2 dimensions"},
      {"huge.nrrd",
       head + "dimension: 3\nsizes: 2000 2000 900\nspacings: 1 1 1\n\n",
       "the limit is 2048 MiB"},
      {"lying.nrrd",
       head + "dimension: 3\nsizes: 1000 1000 900\nspacings: 1 1 1\n\n" + std::string(48, 'v'),
       "announces 1800000000 bytes"},
      {"block.nrrd",
       "NRRD0004\ntype: block\nblock size: 5\nencoding: raw\n" + grid + "\n" +
           std::string(120, 'v'),
       "block.nrrd cannot be read: it is cut short, or its header has a wrong size"},
      {"nan_spacing.nrrd",
       head + "dimension: 3\nsizes: 4 3 2\nspacings: nan nan nan\n\n" + std::string(48, 'v'),
       "its spacings are \"nan nan nan\""},
      {"gone.nhdr", head + grid + "data file: gone.raw\n", "cannot be read"},
      {"list.nhdr", head + grid + "datafile: LIST\none.raw\ntwo.raw\n", "in several files"},
      {"pattern.nhdr", head + grid + "data file: %d.raw 1 2 1\n", "in several files"},
      {"half_gzip.nrrd",
       "NRRD0004\ntype: short\nencoding: gzip\nendian: little\n" + grid + "\n" +
           std::string("\x1f\x8b\x08\0\0\0\0\0\0\3", 10),
       "cannot be read"},
  });
}

/// A NIfTI-1 head with its voxels, some of its fields spoilt.
struct NiftiText {
  std::int32_t head_bytes = 348;
  std::array<std::int16_t, 8> dim = {3, 4, 3, 2, 1, 1, 1, 1};
  std::int16_t type = 4;
  std::int16_t bits = 16;
  std::array<float, 8> spacing = {1, 1, 1, 1, 0, 0, 0, 0};
  float voxels_at = 352;
  std::int16_t sform_code = 0;
  std::array<float, 12> sform = {};
  std::size_t num_voxel_bytes = 48;
  const char* magic = "n+1";

  [[nodiscard]] std::string file() const {
    std::string bytes(352, '\0');
    const auto put = [&](std::size_t at, const auto& value) {
      std::memcpy(bytes.data() + at, &value, sizeof(value));
    };
    put(0, head_bytes);
    put(40, dim);
    put(70, type);
    put(72, bits);
    put(76, spacing);
    put(108, voxels_at);
    put(254, sform_code);
    put(280, sform);
    std::memcpy(bytes.data() + 344, magic, 4);
    return bytes + std::string(num_voxel_bytes, 'v');
  }
};

TEST_F(HostileFiles, Niftis) {
  expect_refused({
      {"empty.nii", "", "damaged"},
      {"short.nii", std::string(100, '\0'), "damaged"},
      {"head.nii", NiftiText{.head_bytes = 12345}.file(), "no NIfTI file"},
      {"version_2.nii", NiftiText{.head_bytes = 540}.file(), "a NIfTI-2 file"},
      {"magic.nii", NiftiText{.magic = "bad"}.file(), "no NIfTI file"},
      {"cut.nii",
       NiftiText{.num_voxel_bytes = 20}.file(),
       "cut short or damaged: 400 bytes are announced"},
      {"flat.nii", NiftiText{.dim = {2, 4, 6, 1, 1, 1, 1, 1}}.file(), "2 dimensions"},
      {"moving.nii", NiftiText{.dim = {4, 2, 3, 2, 2, 1, 1, 1}}.file(), "4 dimensions"},
      {"minus.nii",
       NiftiText{.dim = {3, 4, -3, 2, 1, 1, 1, 1}}.file(),
       "-3 voxels along y, the limits are 2 and 2048"},
      {"zero.nii",
       NiftiText{.dim = {3, 4, 0, 2, 1, 1, 1, 1}}.file(),
       "0 voxels along y, the limits are 2 and 2048"},
      {"nan_place.nii",
       NiftiText{.sform_code = 1, .sform = {1, 0, 0, 0, 0, 1, NAN, 0, 0, 0, 1, 0}}.file(),
       "a number that is not below 1e7"},
      {"endless_place.nii",
       NiftiText{.sform_code = 1, .sform = {1, 0, 0, 0, 0, 1e30F, 1, 0, 0, 0, 1, 0}}.file(),
       "a number that is not below 1e7"},
      {"many.nii",
       NiftiText{.dim = {99, 4, 3, 2, 1, 1, 1, 1}}.file(),
       "99 dimensions, 1 to 7 are possible"},
      {"two_orders.nii",
       NiftiText{.dim = {0x300, 4, 3, 2, 1, 1, 1, 1}}.file(),
       "768 dimensions, 1 to 7 are possible"},
      {"huge.nii",
       NiftiText{.dim = {3, 32000, 32000, 32000, 1, 1, 1, 1}}.file(),
       "32000 voxels along"},
      {"lying.nii",
       NiftiText{.dim = {3, 1000, 1000, 900, 1, 1, 1, 1}}.file(),
       "announces 1800000000 bytes"},
      {"type.nii",
       NiftiText{.type = 9999}.file(),
       "type.nii cannot be read: it is cut short, or its header has a wrong size, spacing or type"},
      {"colour.nii", NiftiText{.type = 128, .bits = 24, .num_voxel_bytes = 72}.file(), "colour"},
      {"complex.nii",
       NiftiText{.type = 32, .bits = 64, .num_voxel_bytes = 192}.file(),
       "complex.nii has 2 values a voxel, a CT has one"},
      {"no_gzip.nii.gz", "this was never compressed", "damaged"},
      {"gzip_start.nii.gz", std::string("\x1f\x8b\x08\0\0\0\0\0\0\3", 10), "damaged"},
      {"wide.nii",
       NiftiText{.spacing = {1, 1, 1, 900, 0, 0, 0, 0}}.file(),
       "must be between 0.01 and 50 mm"},
  });
}

SliceText plain_slice(double height_mm = 0.0) {
  SliceText slice;
  slice.position_mm.z() = height_mm;
  slice.stored.assign(30, 1000);
  return slice;
}

std::string with(std::string file, std::size_t at, const std::string& bytes) {
  return file.replace(at, bytes.size(), bytes);
}

TEST_F(HostileFiles, DicomFiles) {
  const std::string good = slice_file(plain_slice());
  const auto pixels_at = good.rfind("OW") - 4;
  DicomWriter nested;
  for (int level = 0; level < 1000; ++level)
    nested.raw(0x0008'1140, "SQ", 0xffff'ffffU, std::string("\xfe\xff\0\xe0\xff\xff\xff\xff", 8));
  DicomWriter private_nest;
  private_nest.raw(0x0009'1140,
                   "UN",
                   0xffff'ffffU,
                   repeated(std::string("\xfe\xff\0\xe0\xff\xff\xff\xff"
                                        "\x09\0\x40\x11\xff\xff\xff\xff",
                                        16),
                            20000));
  DicomWriter lying;
  lying.raw(0x7fe0'0010, "OW", 0xffff'fff0U, "few");
  DicomWriter endless;
  endless.raw(0x7fe0'0010, "OB", 0xffff'ffffU, std::string("\xfe\xff\0\xe0\0\0\0\0", 8));
  DicomWriter bomb(kDeflated);
  for (int i = 0; i < 40; ++i) bomb.raw(0x0009'1001, "OB", 1U << 20U, std::string(1U << 20U, '\0'));
  std::string broken_deflate = slice_file({.transfer_syntax = kDeflated});
  broken_deflate.resize(broken_deflate.size() - 40);
  auto video = plain_slice();
  video.modality = "XC";
  auto no_modality = plain_slice();
  no_modality.modality = "";
  auto no_place = plain_slice();
  no_place.has_position = false;
  auto no_spacing = plain_slice();
  no_spacing.row_spacing_mm = 0.0;
  auto skew = plain_slice();
  skew.down_column = {0.6, 0.8, 0.0};
  auto nan = plain_slice();
  nan.position_mm.x() = NAN;
  auto wide = plain_slice();
  wide.columns = 30000;
  auto strange_bits = plain_slice();
  strange_bits.bits_stored = 40;
  const auto cut_at = [](const char* place) {
    return std::string("cut short or damaged (at byte ") + place + "): copy the series again";
  };
  expect_refused({
      {"one.dcm", good, "fewer than 3 slices"},
      {"cut_in_pixels.dcm", good.substr(0, good.size() - 10), cut_at("368 of 418")},
      {"cut_in_head.dcm", good.substr(0, pixels_at - 60), cut_at("292 of 296")},
      {"cut_in_tag.dcm", good.substr(0, pixels_at + 3), cut_at("356 of 359")},
      {"only_preamble.dcm", good.substr(0, 132), "it names no modality"},
      {"lying_length.dcm", lying.file(), cut_at("12 of 15")},
      {"endless_pixels.dcm", endless.file(), cut_at("20 of 20")},
      {"nested.dcm", nested.file(), "nests sequences deeper than 64 levels"},
      {"nested_unknown.dcm", private_nest.file(), "nests sequences deeper than 64 levels"},
      {"bomb.dcm", bomb.file(), "it is no picture"},
      {"broken_deflate.dcm", broken_deflate, "cut short or damaged: copy the series again"},
      {"bad_type.dcm", with(good, 144 + 20, "??????????????????????????"), cut_at("0 of 428")},
      {"no_pixels.dcm", slice_file({}), "it has no pixels"},
      {"video.dcm", slice_file(video), "its modality is XC, not CT"},
      {"no_modality.dcm", slice_file(no_modality), "it names no modality"},
      {"no_place.dcm", slice_file(no_place), "it has no position in space"},
      {"nan_place.dcm", slice_file(nan), "it has no position in space"},
      {"skew.dcm", slice_file(skew), "it has no position in space"},
      {"no_spacing.dcm", slice_file(no_spacing), "no pixel spacing above 0 mm"},
      {"wide.dcm", slice_file(wide), "it has 30000 x 5 pixels, the limit is 2048 a side"},
      {"strange_bits.dcm", slice_file(strange_bits), "stores 40 of 16 bits a pixel"},
      {"zip.zip", "PK\x03\x04 and then nothing", "no whole zip archive"},
      {"liar.zip", lying_zip(), "it says that it holds 134217728 bytes of one file, and has "},
      {"picture.jpg", "\xff\xd8\xff\xe0 JFIF", "no CT that is read here"},
      {"program.dcm",
       "\x7f"
       "ELF and more",
       "no CT that is read here"},
  });
}

/// Faults that only show when the slices are put together.
TEST_F(HostileFiles, DicomSeries) {
  const auto write_three = [&](const SliceText& spoilt) {
    for (int k = 0; k < 2; ++k) write("s/" + std::to_string(k), slice_file(plain_slice(k)));
    SliceText last = spoilt;
    last.sop_instance_uid = "5.5";
    write("s/2", slice_file(last));
    return folder_ / "s";
  };
  EXPECT_EQ(error_of(write_three(plain_slice(2))), "no error");
  EXPECT_THAT(error_of(write_three(plain_slice(40))), HasSubstr("slices are missing"));
  auto shifted = plain_slice(2);
  shifted.position_mm.x() = 3000.0;
  EXPECT_THAT(error_of(write_three(shifted)), HasSubstr("the limits are 2048 a side"));
  auto few_pixels = plain_slice(2);
  few_pixels.stored.resize(7);
  EXPECT_THAT(error_of(write_three(few_pixels)), HasSubstr("damaged or missing pixels"));
  auto far = plain_slice(2);
  far.position_mm.z() = 1e300;
  EXPECT_THAT(error_of(write_three(far)), HasSubstr("lie 1e+300 mm apart"));
  auto far_aside = plain_slice(2);
  far_aside.position_mm.x() = 1e12;
  EXPECT_THAT(error_of(write_three(far_aside)), HasSubstr("would have 2e+12 x 5 x 3 voxels"));
  auto claims_compression = plain_slice(2);
  std::string file = slice_file(claims_compression);
  // The pixels as one fragment of nonsense in a syntax that needs a decoder.
  DicomWriter out("1.2.840.10008.1.2.4.90");
  out.raw(0x7fe0'0010,
          "OB",
          0xffff'ffffU,
          std::string("\xfe\xff\0\xe0\0\0\0\0\xfe\xff\0\xe0\x04\0\0\0nope\xfe\xff\xdd\xe0\0\0\0\0",
                      28));
  const auto meta = out.file();
  const auto data_at = file.find(std::string("\x08\0\x08\0", 4), 132);
  const auto pixels_at = file.rfind("OW") - 4;
  const auto out_at = meta.find(std::string("\xe0\x7f\x10\0", 4), 132);
  write_three(plain_slice(2));
  write("s/2",
        meta.substr(0, out_at) + file.substr(data_at, pixels_at - data_at) + meta.substr(out_at));
  EXPECT_THAT(error_of(folder_ / "s"), HasSubstr("s/2 has damaged or missing pixels"));
  auto unknown = meta;
  unknown.replace(unknown.find("1.2.840.10008.1.2.4.90"), 22, "1.2.840.10008.1.2.9.99");
  write("s/2",
        unknown.substr(0, out_at) + file.substr(data_at, pixels_at - data_at) +
            unknown.substr(out_at));
  EXPECT_THAT(error_of(folder_ / "s"), HasSubstr("transfer syntax 1.2.840.10008.1.2.9.99"));
}

/// What a case file, a page and a terminal can show, whatever character set the scanner wrote in.
TEST_F(HostileFiles, TextOfAnotherCharacterSetIsMadePrintable) {
  for (int k = 0; k < 3; ++k) {
    auto slice = plain_slice(k);
    slice.series_description =
        "Sch\xe4"
        "del\x1b[31m";
    write(std::to_string(k), slice_file(slice));
  }
  const auto series = list_ct_series(folder_, {});
  ASSERT_TRUE(series) << series.error().message;
  EXPECT_EQ(series->front().description, "Sch\u00e4del [31m");
  const auto volume = import_volume(folder_, {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_THAT(volume->description, HasSubstr("\"Sch\u00e4del [31m\""));
}

TEST_F(HostileFiles, Folders) {
  EXPECT_THAT(error_of(folder_ / "none"), HasSubstr("there is no file or folder"));
  EXPECT_THAT(error_of(folder_), HasSubstr("holds no DICOM file"));
  fs::create_symlink(folder_, folder_ / "loop");
  fs::create_symlink("/dev/zero", folder_ / "zero");
  EXPECT_THAT(error_of(folder_), HasSubstr("holds no DICOM file"));
  EXPECT_THAT(error_of("/dev/null"), HasSubstr("no CT that is read here"));
  write("DICOMDIR", [] {
    DicomWriter record;
    record.text(0x0004'1500, "CS", "..\\..\\etc\\passwd");
    DicomWriter directory;
    directory.sequence(0x0004'1220, {record.data()});
    return directory.file();
  }());
  EXPECT_THAT(error_of(folder_ / "DICOMDIR"), HasSubstr("names no file that is there"));
}

/// Found by fuzzing: GDCM would read past its stream in one, and run into an assertion in the
/// other.
TEST_F(HostileFiles, ThatWouldBringDownGdcmHaveDamagedPixels) {
  for (const std::string name : {"rle_streams.dcm", "jpeg16_assert.dcm"}) {
    for (const auto& slice : testing_files::sample_neighbours()) write(slice.name, slice.bytes);
    fs::copy_file(fs::path(MORGAGNI_TESTDATA) / "hostile" / name, folder_ / name);
    EXPECT_THAT(error_of(folder_),
                AllOf(HasSubstr(name), HasSubstr("has damaged or missing pixels")));
    fs::remove(folder_ / name);
  }
}

}  // namespace
}  // namespace mor
