// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tls.h"

#include <utility>

namespace mor::dimse {
namespace {

tl::unexpected<Error> unusable(const std::string& what, const std::string& file) {
  return make_error(ErrorCode::kInvalidArgument,
                    file + ": cannot be used as the " + what +
                        " of the TLS connection (PEM, "
                        "without a password)");
}

Result<void> load_identity(const TlsFiles& files, DcmTLSTransportLayer& layer) {
  if (files.certificate.empty() && files.key.empty()) return {};
  layer.setPrivateKeyPasswd("");  // Else a key with one asks at the terminal.
  if (layer.setPrivateKeyFile(files.key.c_str(), DCF_Filetype_PEM).bad())
    return unusable("private key", files.key);
  if (layer.setCertificateFile(files.certificate.c_str(), DCF_Filetype_PEM).bad())
    return unusable("certificate", files.certificate);
  if (!layer.checkPrivateKeyMatchesCertificate()) {
    return make_error(ErrorCode::kInvalidArgument,
                      files.key + " is not the private key of " + files.certificate);
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<DcmTLSTransportLayer>> make_tls(const TlsFiles& files,
                                                       T_ASC_NetworkRole role) {
  std::unique_ptr<DcmTLSTransportLayer> layer;
  if (!files.enabled) return layer;
  layer = std::make_unique<DcmTLSTransportLayer>(role, nullptr, OFTrue);
  if (layer->setTLSProfile(TSP_Profile_BCP195_ND).bad())
    return make_error(ErrorCode::kInternal, "TLS cannot be set up");
  MOR_CHECK(load_identity(files, *layer));
  if (!files.ca.empty() &&
      layer->addTrustedCertificateFile(files.ca.c_str(), DCF_Filetype_PEM).bad())
    return unusable("trusted certificate", files.ca);
  layer->setCertificateVerification(files.ca.empty() ? DCV_ignoreCertificate
                                                     : DCV_requireCertificate);
  if (layer->activateCipherSuites().bad())
    return make_error(ErrorCode::kInternal, "TLS cannot be set up: no cipher suite");
  return layer;
}

}  // namespace mor::dimse
