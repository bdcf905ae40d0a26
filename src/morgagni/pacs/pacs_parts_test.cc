// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The parsers of what a PACS says, and the pieces around them. tests/pacs has the whole, against a
// real PACS and hostile ones.

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/pacs/internal/dicom_json.h"
#include "morgagni/pacs/internal/dimse_task.h"
#include "morgagni/pacs/internal/multipart_reader.h"
#include "morgagni/pacs/internal/part10.h"
#include "morgagni/pacs/pacs_address.h"
#include "morgagni/pacs/received_journal.h"
#include "morgagni/pacs/study_gatherer.h"

namespace mor {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace std::chrono_literals;

TEST(PacsAddress, HasOneFormForAllWays) {
  const auto web = parse_pacs_address("https://pacs.example:8443/dicom-web/").value();
  EXPECT_EQ(web.kind, PacsAddress::Kind::kDicomweb);
  EXPECT_EQ(web.url, "https://pacs.example:8443/dicom-web");
  EXPECT_TRUE(web.tls);
  const auto plain = parse_pacs_address("dicom://MY%20PACS@10.0.0.7").value();
  EXPECT_EQ(plain.kind, PacsAddress::Kind::kDimse);
  EXPECT_EQ(plain.aet, "MY PACS");
  EXPECT_EQ(plain.host, "10.0.0.7");
  EXPECT_EQ(plain.port, 104);
  EXPECT_FALSE(plain.tls);
  EXPECT_EQ(parse_pacs_address("dicoms://P@h")->port, 2762);
  EXPECT_EQ(parse_pacs_address("dicoms://P@h:11113")->port, 11113);
  EXPECT_EQ(parse_pacs_address("dicom://P@[::1]:4242")->host, "::1");
}

TEST(PacsAddress, SaysWhatIsWrong) {
  for (const auto& [text, why] : std::vector<std::pair<const char*, const char*>>{
           {"pacs.example", "not an address"},
           {"gopher://pacs.example", "not a way to a PACS"},
           {"dicom://pacs.example", "AE title"},
           {"dicom://PACS@pacs.example/studies", "has no path"},
           {"dicom://SEVENTEEN-LETTERS@h", "1 to 16"},
           {"dicom://A%5CB@h", "backslash"},
           {"https://u:p@pacs.example/x", "--user"},
           {"https://pacs.example/x?limit=3", "without ?"},
           {"https:///x", "host is missing"},
           {"dicom://P@h:99999", "not an address"}}) {
    const auto address = parse_pacs_address(text);
    ASSERT_FALSE(address) << text;
    EXPECT_THAT(address.error().message, HasSubstr(why)) << text;
  }
}

TEST(PacsAddress, TellsThisComputerFromOthers) {
  for (const char* host : {"localhost", "127.0.0.1", "127.8.0.1", "::1"})
    EXPECT_TRUE(is_loopback(host)) << host;
  for (const char* host : {"127.example.com", "127.", "128.0.0.1", "0.0.0.0", ""})
    EXPECT_FALSE(is_loopback(host)) << host;
}

TEST(StorageReceiver, RefusesWhatItCannotKeepTo) {
  ReceiverOptions options{.use_tls = true, .tls = {.ca = "ca.pem", .certificate = "my.pem"}};
  EXPECT_THAT(options.check().error().message, HasSubstr("needs --certificate and --key"));
  EXPECT_THAT(internal::dimse_text({{"folder", "f\xe4lle"}}).error().message,
              HasSubstr("\"fälle\" is not UTF-8"));
  EXPECT_EQ(internal::dimse_text({{"folder", "fälle"}}).value(), "{\"folder\":\"fälle\"}");
}

TEST(Uid, IsAHarmlessNameOfAFile) {
  EXPECT_TRUE(is_dicom_uid("1.2.840.10008.1.2"));
  for (const char* text : {"", ".", "..", "1..2", ".1", "1.", "1/2", "../1", "1.2\n", "a"})
    EXPECT_FALSE(is_dicom_uid(text)) << text;
  EXPECT_TRUE(is_dicom_uid(std::string(64, '1')));
  EXPECT_FALSE(is_dicom_uid(std::string(65, '1')));
}

TEST(TerminalText, IsNoCommand) {
  EXPECT_EQ(terminal_text("Müller^Örs"), "Müller^Örs");
  EXPECT_EQ(terminal_text("\x1b[2Jx\r\n\t"), " [2Jx   ");
  EXPECT_EQ(terminal_text("a\u202Eb"), "a b") << "turns what follows around";
  EXPECT_EQ(terminal_text("M\xfcller"), "Müller") << "Latin-1";
  EXPECT_EQ(terminal_text(std::string(1000, 'x')).size(), 200U);
}

TEST(DicomJson, TakesTextsNumbersAndNames) {
  const auto found = internal::parse_dicom_json(
      R"([{"00100010":{"vr":"PN","Value":[{"Alphabetic":"Doe^Jane","Ideographic":"x"}]},
           "00080061":{"vr":"CS","Value":["CT","SR"]},
           "00201209":{"vr":"IS","Value":[138]}, "00081030":{"vr":"LO"},
           "00081140":{"vr":"SQ","Value":[{"00081150":{"vr":"UI"}}]}, "note":"x"}, {}])");
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_THAT(*found, SizeIs(2));
  const auto& values = found->front();
  EXPECT_EQ(values.at("00100010"), "Doe^Jane");
  EXPECT_EQ(values.at("00080061"), "CT\\SR");
  EXPECT_EQ(values.at("00201209"), "138");
  EXPECT_EQ(values.at("00081030"), "");
  EXPECT_EQ(values.at("00081140"), "");
  EXPECT_EQ(values.count("note"), 0U);
}

TEST(DicomJson, RefusesWhatIsNone) {
  EXPECT_THAT(internal::parse_dicom_json("<html>").error().message, HasSubstr("not a list"));
  EXPECT_THAT(internal::parse_dicom_json("{}").error().message, HasSubstr("not a list"));
  EXPECT_THAT(internal::parse_dicom_json("[1]").error().message,
              HasSubstr("not a list of objects"));
  EXPECT_THAT(internal::parse_dicom_json(std::string(1000000, '[')).error().message,
              HasSubstr("nested"));
  EXPECT_FALSE(internal::parse_dicom_json("[{\"a\":"));
}

/// What a reader hands on.
struct Parts {
  std::vector<std::string> whole;
  std::string open;

  internal::PartSink sink() {
    return {
        [this]() -> Result<void> { return open.clear(), Result<void>(); },
        [this](std::string_view bytes) -> Result<void> { return open += bytes, Result<void>(); },
        [this]() -> Result<void> { return whole.push_back(open), Result<void>(); }};
  }
};

TEST(Multipart, ComesApartHoweverItIsCut) {
  const std::string tricky = "\r\n--X\r\n--B\r\r\n--\r\n-";
  const std::string body = "preamble\r\n--BB\r\nContent-Type: application/dicom\r\nA: b\r\n\r\n" +
                           tricky +
                           "\r\n--BB \r\n\r\nsecond\r\n--BB\r\nC: d\r\n\r\n\r\n--BB--\r\nepilogue";
  for (std::size_t step = 1; step <= body.size(); ++step) {
    Parts parts;
    internal::MultipartReader reader("BB", parts.sink());
    for (std::size_t at = 0; at < body.size(); at += step)
      ASSERT_TRUE(reader.feed(std::string_view(body).substr(at, step))) << step;
    EXPECT_TRUE(reader.finish());
    EXPECT_THAT(parts.whole, ElementsAre(tricky, "second", "")) << step;
  }
}

TEST(Multipart, SaysWhereItIsBroken) {
  const auto read = [](std::string_view body) {
    Parts parts;
    internal::MultipartReader reader("BB", parts.sink());
    auto outcome = reader.feed(body);
    return outcome ? reader.finish() : outcome;
  };
  EXPECT_TRUE(read("--BB--"));
  EXPECT_THAT(read("").error().message, HasSubstr("too early"));
  EXPECT_THAT(read("--BB\r\n\r\nhalf").error().message, HasSubstr("too early"));
  EXPECT_THAT(read("--BBB\r\n\r\nx").error().message, HasSubstr("goes on"));
  EXPECT_THAT(read("--BB" + std::string(100, ' ')).error().message, HasSubstr("no end of line"));
  EXPECT_THAT(read("--BB\r\n" + std::string(20000, 'h')).error().message, HasSubstr("no end"));
}

TEST(Multipart, FindsItsBoundary) {
  EXPECT_EQ(internal::multipart_boundary("multipart/related; type=\"application/dicom\"; "
                                         "boundary=\"a b;c\"")
                .value(),
            "a b;c");
  EXPECT_EQ(internal::multipart_boundary("Multipart/Related;boundary=xyz").value(), "xyz");
  for (const std::string type : {"",
                                 "application/dicom",
                                 "multipart/related",
                                 "multipart/related; boundary=",
                                 "multipart/form-data; boundary=x"})
    EXPECT_FALSE(internal::multipart_boundary(type)) << type;
  EXPECT_FALSE(internal::multipart_boundary("multipart/related; boundary=" + std::string(71, 'x')));
}

std::string file_head(const std::string& uid) {
  std::string head(128, '\0');
  head += std::string("DICM\x02\x00\x00\x00UL\x04\x00\x40\x00\x00\x00", 16);
  head += std::string("\x02\x00\x01\x00OB\x00\x00\x02\x00\x00\x00\x00\x01", 14);
  head += std::string("\x02\x00\x03\x00UI", 6);
  head += static_cast<char>(uid.size());
  return head + '\0' + uid;
}

TEST(Part10, NamesItsObject) {
  EXPECT_EQ(internal::part10_uid(file_head(std::string("1.2.3\0", 6)) + "rest").value(), "1.2.3");
  EXPECT_FALSE(internal::part10_uid(""));
  EXPECT_FALSE(internal::part10_uid("MZ" + std::string(500, 'x')));
  EXPECT_FALSE(internal::part10_uid(file_head("../../x1")));
  EXPECT_FALSE(internal::part10_uid(file_head("")));
  const auto whole = file_head("1.2.30") + "0123456789ab";
  for (std::size_t length = 0; length < file_head("1.2.30").size(); ++length)
    EXPECT_FALSE(internal::part10_uid(std::string_view(whole).substr(0, length))) << length;
}

ReceivedObject object(const std::string& study, const std::string& series, const std::string& uid) {
  return {.file = "/r/" + study + "/" + series + "/" + uid + ".dcm",
          .uid = uid,
          .study_uid = study,
          .series_uid = series,
          .modality = "CT",
          .patient_id = "../../0815 \x1b[2J",
          .study_date = "20260131",
          .series_number = series.substr(series.size() - 1),
          .series_description = "Thorax"};
}

TEST(StudyGatherer, HandsAStudyOutWhenItIsQuiet) {
  StudyGatherer gatherer(10s);
  const StudyGatherer::Clock::time_point start{};
  EXPECT_FALSE(gatherer.next_due());
  EXPECT_TRUE(gatherer.add(object("1.1", "1.1.2", "1"), start));
  EXPECT_FALSE(gatherer.add(object("1.1", "1.1.2", "2"), start + 4s));
  EXPECT_TRUE(gatherer.add(object("1.1", "1.1.1", "3"), start + 5s));
  EXPECT_TRUE(gatherer.add(object("2.2", "2.2.1", "4"), start + 6s));
  EXPECT_EQ(*gatherer.next_due(), start + 15s);
  EXPECT_THAT(gatherer.take_quiet(start + 14s), IsEmpty());
  EXPECT_TRUE(gatherer.has("1.1", "1.1.1"));
  const auto quiet = gatherer.take_quiet(start + 15s);
  ASSERT_THAT(quiet, SizeIs(2));
  EXPECT_FALSE(gatherer.has("1.1", "1.1.1"));
  EXPECT_TRUE(gatherer.has("2.2", "2.2.1"));
  EXPECT_EQ(quiet[0].last.series_uid, "1.1.1");
  EXPECT_EQ(quiet[1].num_objects, 2);
  EXPECT_EQ(quiet[1].folder, "/r/1.1/1.1.2");
  EXPECT_EQ(*gatherer.next_due(), start + 16s);
  EXPECT_TRUE(gatherer.add(object("1.1", "1.1.2", "5"), start + 20s)) << "it begins anew";
}

TEST(StudyGatherer, NamesCasesHarmlesslyAndApart) {
  StudyGatherer gatherer(1s);
  gatherer.add(object("1.1", "1.1.7", "1"), {});
  gatherer.add(object("1.1", "1.2.7", "2"), {});
  const auto quiet = gatherer.take_quiet(StudyGatherer::Clock::time_point(2s));
  ASSERT_THAT(quiet, SizeIs(2));
  EXPECT_THAT(quiet[0].case_name(), testing::MatchesRegex("0815-2J_20260131_series7_[0-9a-f]{8}"));
  EXPECT_NE(quiet[0].case_name(), quiet[1].case_name());
  EXPECT_TRUE(quiet[0].is_ct());
}

TEST(ReceivedJournal, RemembersWhatIsNoCaseYet) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("mor_journal_" + std::to_string(getpid()));
  const ReceivedJournal journal(folder);
  EXPECT_THAT(journal.read(), IsEmpty());
  ASSERT_TRUE(journal.add(object("1.1", "1.1.2", "1")));
  ASSERT_TRUE(journal.add(object("1.1", "1.1.3", "2")));
  journal.remove("1.1.2");
  const auto left = journal.read();
  ASSERT_THAT(left, SizeIs(1));
  EXPECT_EQ(left[0].series_uid, "1.1.3");
  EXPECT_EQ(left[0].file, folder / "1.1" / "1.1.3" / "2.dcm");
  EXPECT_EQ(left[0].modality, "CT");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace mor
