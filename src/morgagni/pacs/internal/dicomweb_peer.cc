// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/dicomweb_peer.h"

#include <cstring>
#include <memory>
#include <optional>
#include <set>

#include <glib.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/log.h"
#include "morgagni/pacs/internal/dicom_json.h"
#include "morgagni/pacs/internal/http_client.h"
#include "morgagni/pacs/internal/multipart_reader.h"
#include "morgagni/pacs/internal/object_folder.h"

namespace mor::internal {
namespace {

constexpr std::size_t kMaxQueryBytes = 32ULL << 20U;
constexpr const char* kJson = "application/dicom+json";
/// As the PACS keeps it, whatever its coding.
constexpr const char* kObjects = "multipart/related; type=\"application/dicom\"; transfer-syntax=*";

/// What a server understands even if it does not take %5E for ^, as Orthanc's does not: anything
/// unusual matches anything, and fits() looks closer at what is found.
std::string loose_pattern(const std::string& text) {
  std::string pattern;
  for (const char letter : text) {
    const bool usual = g_ascii_isalnum(letter) != FALSE || std::strchr("*-._", letter) != nullptr;
    if (usual) pattern += letter;
    if (!usual && !pattern.ends_with('*')) pattern += '*';
  }
  return pattern;
}

std::string folded(const std::string& text) {
  const std::unique_ptr<char, decltype(&g_free)> valid(
      g_utf8_make_valid(text.c_str(), static_cast<gssize>(text.size())), g_free);
  const std::unique_ptr<char, decltype(&g_free)> fold(g_utf8_casefold(valid.get(), -1), g_free);
  return fold.get();
}

/// Whatever the case of letters; * and ? stand for others.
bool fits(const std::string& pattern, const std::string& text) {
  return pattern.empty() ||
         g_pattern_match_simple(folded(pattern).c_str(), folded(text).c_str()) != FALSE;
}

bool fits(const PacsFilter& filter, const PacsStudy& study) {
  return fits(filter.patient_name, study.patient_name) &&
         fits(filter.patient_id, study.patient_id) && fits(filter.accession, study.accession);
}

class DicomwebPeer : public PacsPeer {
 public:
  DicomwebPeer(std::string url, PacsOptions options, std::unique_ptr<HttpClient> http)
      : url_(std::move(url)), options_(std::move(options)), http_(std::move(http)) {}

  Result<void> echo(std::stop_token stop) override {
    MOR_CHECK(query("/studies?limit=1", stop));
    return {};
  }

  Result<PacsStudies> find_studies(const PacsFilter& filter, std::stop_token stop) override {
    MOR_CHECK(filter.check());
    std::string path = fmt::format("/studies?limit={}&fuzzymatching=false", kMaxStudies + 1);
    for (const auto& [name, value] : keys_of(filter))
      path += "&" + name + "=" + loose_pattern(value);
    for (const char* name : {tag::kStudyDescription, tag::kModalitiesInStudy})
      path += std::string("&includefield=") + name;
    MOR_TRY(const auto found, query(path, stop));
    PacsStudies result;
    // The server ends its list there, whether or not all of it fits.
    result.has_more = found.size() > kMaxStudies;
    for (const auto& values : found) {
      const auto study = study_of(values);
      if (result.studies.size() == kMaxStudies) break;
      if (is_dicom_uid(study.uid) && fits(filter, study)) result.studies.push_back(study);
    }
    return result;
  }

  Result<std::vector<PacsSeries>> find_series(const std::string& study_uid,
                                              std::stop_token stop) override {
    std::string path = fmt::format("/studies/{}/series?limit={}", study_uid, kMaxSeries);
    for (const char* name : {tag::kSeriesDescription, tag::kNumSeriesInstances})
      path += std::string("&includefield=") + name;
    MOR_TRY(const auto found, query(path, stop));
    std::vector<PacsSeries> all;
    for (const auto& values : found) {
      auto series = series_of(values, study_uid);
      if (is_dicom_uid(series.uid) && all.size() < kMaxSeries) all.push_back(std::move(series));
    }
    return all;
  }

  Result<std::vector<std::string>> find_instances(const PacsSeries& series,
                                                  std::stop_token stop) override {
    std::set<std::string> all;
    // A server may give fewer at a time than there are.
    while (true) {
      MOR_TRY(const auto found,
              query(fmt::format("/studies/{}/series/{}/instances?limit={}&offset={}",
                                series.study_uid,
                                series.uid,
                                kMaxInstances,
                                all.size()),
                    stop));
      const auto before = all.size();
      for (const auto& values : found) {
        const auto uid = value_of(values, tag::kSopInstanceUid);
        if (is_dicom_uid(uid) && all.size() < kMaxInstances) all.insert(uid);
      }
      // Not every server says how many there are.
      const bool may_be_more =
          series.num_instances == 0 || static_cast<int>(all.size()) < series.num_instances;
      if (all.size() == before || !may_be_more) break;
    }
    return std::vector<std::string>(all.begin(), all.end());
  }

  Result<void> fetch(const PacsSeries& series,
                     const std::vector<std::string>& wanted,
                     bool all,
                     const std::filesystem::path& folder,
                     const OnObject& on_object,
                     std::stop_token stop) override {
    ObjectFolder objects(folder, wanted, options_, on_object);
    const auto path = fmt::format("{}/studies/{}/series/{}", url_, series.study_uid, series.uid);
    if (all) return fetch_objects(path, objects, stop);
    Result<void> outcome;
    for (const auto& uid : wanted) {
      auto fetched = fetch_objects(path + "/instances/" + uid, objects, stop);
      if (fetched) continue;
      outcome = std::move(fetched);
      // One that is missing there keeps no other from coming.
      const auto code = outcome.error().code;
      if (code != ErrorCode::kNotFound && code != ErrorCode::kUnsupported) break;
    }
    return outcome;
  }

 private:
  Result<std::vector<TagValues>> query(const std::string& path, std::stop_token stop) {
    std::string text;
    bool empty = false;
    const HttpSink sink{
        [&](const HttpAnswer& answer) -> Result<void> {
          empty = answer.status == 204;
          return {};
        },
        [&](std::string_view bytes) -> Result<void> {
          if (text.size() + bytes.size() <= kMaxQueryBytes) return text += bytes, Result<void>();
          return make_error(
              ErrorCode::kInvalidArgument,
              fmt::format("{} answers a query with more than {} MB", url_, kMaxQueryBytes >> 20U));
        }};
    MOR_CHECK(http_->get(url_ + path, kJson, sink, stop));
    if (empty) return std::vector<TagValues>();
    auto parsed = parse_dicom_json(text);
    if (!parsed)
      return make_error(parsed.error().code, fmt::format("{}: {}", url_, parsed.error().message));
    return parsed;
  }

  Result<void> fetch_objects(const std::string& url, ObjectFolder& objects, std::stop_token stop) {
    std::optional<MultipartReader> reader;
    const HttpSink sink{
        [&](const HttpAnswer& answer) -> Result<void> {
          MOR_TRY(const auto boundary, multipart_boundary(answer.content_type));
          reader.emplace(boundary,
                         PartSink{[&] { return objects.begin(); },
                                  [&](std::string_view bytes) { return objects.append(bytes); },
                                  [&] { return objects.end(); }});
          return {};
        },
        [&](std::string_view bytes) { return reader->feed(bytes); }};
    MOR_CHECK(http_->get(url, kObjects, sink, stop));
    return reader->finish();
  }

  std::string url_;
  PacsOptions options_;
  std::unique_ptr<HttpClient> http_;
};

}  // namespace

Result<std::unique_ptr<PacsPeer>> open_dicomweb_peer(const PacsAddress& address,
                                                     const PacsOptions& options) {
  MOR_TRY(auto http, HttpClient::create(options));
  const bool has_secret = !options.user.empty() || !options.token.empty();
  if (has_secret && !address.tls && !is_loopback(address.host)) {
    log::warn("{}: the password goes over the network for all to read; https:// hides it",
              address.url);
  }
  return std::make_unique<DicomwebPeer>(address.url, options, std::move(http));
}

}  // namespace mor::internal
