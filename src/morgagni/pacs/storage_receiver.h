// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/pacs/pacs_peer.h"

namespace mor {

struct ReceiverOptions {
  std::string aet = "MORGAGNI";
  std::string listen_address = "127.0.0.1";  ///< Of this computer, as numbers.
  std::uint16_t port = 11112;                ///< 0: any free one.
  bool use_tls = false;  ///< With `tls`; its CA, if any, must vouch for callers.
  PacsTls tls = {};
  std::vector<std::string> accepted_callers = {};  ///< AE titles; empty: any.
  bool any_called_aet = false;                     ///< Whatever AE title of ours they call.
  int max_associations = 8;                        ///< At once. 1..64.
  std::chrono::seconds idle_timeout{60};
  std::chrono::seconds max_duration{3600};  ///< Of an association.
  std::uint64_t max_object_bytes = 2000000000;
  std::uint64_t min_free_bytes = 1000000000;  ///< Of the disk, else objects are refused.
  std::filesystem::path folder = {};           ///< Made where it is not there.

  [[nodiscard]] Result<void> check() const;
};

/// One object that came whole: FOLDER/STUDY/SERIES/UID.dcm. Its words are a stranger's.
struct ReceivedObject {
  std::filesystem::path file = {};
  std::string uid;
  std::string study_uid;
  std::string series_uid;
  std::string modality;
  std::string patient_id;
  std::string study_date;
  std::string series_number;
  std::string series_description;
};

/// A DICOM Storage SCP (C-STORE, C-ECHO). Each association is served by a process of its own, which
/// may die; datasets are written as they come.
class StorageReceiver {
 public:
  /// Called when an object is on disk, maybe before its sender is told; from several threads.
  using OnReceived = std::function<void(const ReceivedObject&)>;

  /// @errors kInvalidArgument: options; kDevice: the address cannot be listened on; kNotFound:
  /// morgagni-dimse; kIo: the folder.
  [[nodiscard]] static Result<std::unique_ptr<StorageReceiver>> start(
      const ReceiverOptions& options, OnReceived on_received);
  /// Ends all associations.
  virtual ~StorageReceiver() = default;

  [[nodiscard]] virtual std::uint16_t port() const = 0;

  /// Takes no more associations, and gives those that are there so much time to end.
  virtual void finish(std::chrono::seconds patience) = 0;
};

}  // namespace mor
