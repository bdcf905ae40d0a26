// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "morgagni/core/result.h"

#include "dcmtk/config/osconfig.h"
#include "dcmtk/dcmnet/scu.h"
#include "object_store.h"
#include "task.h"
#include "tls.h"

namespace mor::dimse {

/// A kind of object or service, and the codings of it that are proposed together.
struct Proposal {
  std::string abstract_syntax;
  std::vector<std::string> transfer_syntaxes;
  T_ASC_SC_ROLE role = ASC_SC_ROLE_DEFAULT;
};

/// Explicit and implicit little endian: what every peer speaks.
[[nodiscard]] std::vector<std::string> plain_codings();

/// What the import reads beside them, but for the deflated one, which can unpack to anything.
[[nodiscard]] std::vector<std::string> further_codings();

/// DCMTK's requestor with our limits: it hands matches to the parent, and writes what C-GET brings
/// as it comes.
class Scu : public DcmSCU {
 public:
  explicit Scu(const Task& task);

  /// Connects and negotiates. @errors kIo, kTimeout; kInvalidArgument: the peer refuses us (it says
  /// why), a TLS file.
  [[nodiscard]] Result<void> connect(const std::vector<Proposal>& proposals);

  /// Of a negotiated service. @errors kUnsupported: the peer does not offer it.
  [[nodiscard]] Result<T_ASC_PresentationContextID> context_of(const std::string& abstract_syntax,
                                                               const std::string& service);

  /// "pacs.example:104".
  [[nodiscard]] std::string peer() const;
  /// What a status of the network means, in words.
  [[nodiscard]] Error error_of(const OFCondition& status) const;

  [[nodiscard]] bool has_too_many() const { return has_too_many_; }
  /// The final status that C-FIND, C-GET or C-MOVE gave.
  [[nodiscard]] unsigned final_status() const { return final_status_; }
  [[nodiscard]] int num_failed() const { return num_failed_; }

 protected:
  OFCondition handleFINDResponse(T_ASC_PresentationContextID context,
                                 QRResponse* response,
                                 OFBool& wait_for_next) override;
  OFCondition handleCGETResponse(T_ASC_PresentationContextID context,
                                 RetrieveResponse* response,
                                 OFBool& go_on) override;
  OFCondition handleMOVEResponse(T_ASC_PresentationContextID context,
                                 RetrieveResponse* response,
                                 OFBool& wait_for_next) override;
  OFCondition handleSTORERequestFile(T_ASC_PresentationContextID* context,
                                     const OFString& filename,
                                     T_DIMSE_C_StoreRQ* request) override;
  void notifyRECEIVEProgress(unsigned long num_bytes) override;

 private:
  OFCondition negotiate();
  void remember(const RetrieveResponse& response);

  const Task& task_;
  std::unique_ptr<DcmTLSTransportLayer> tls_;
  ObjectStore store_;
  int num_matches_ = 0;
  bool has_too_many_ = false;
  unsigned final_status_ = 0;
  int num_failed_ = 0;
  std::string rejection_;
};

}  // namespace mor::dimse
