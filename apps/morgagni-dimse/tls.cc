// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tls.h"

#include <utility>

#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <spdlog/fmt/fmt.h>

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

/// A connection a process: its own last refusal.
std::string& last_refusal() {
  static std::string refusal;
  return refusal;
}

std::string words_of(int error) {
  switch (error) {
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH:
      return "it is made out to another host";
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return "it has expired";
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return "it is not valid yet";
    default:
      return fmt::format("--ca does not vouch for it ({})", X509_verify_cert_error_string(error));
  }
}

int note_refusal(int is_good, X509_STORE_CTX* context) {
  if (is_good == 0) last_refusal() = words_of(X509_STORE_CTX_get_error(context));
  return is_good;
}

/// DCMTK verifies the chain of signatures alone, as DICOM's profile has it: whoever has any
/// certificate of the hospital's could stand in for the PACS.
Result<void> expect_host(DcmTLSTransportLayer& layer, const std::string& host) {
  auto* context = layer.getNativeHandle();
  auto* wanted = SSL_CTX_get0_param(context);
  X509_VERIFY_PARAM_set_hostflags(wanted, X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS);
  if (X509_VERIFY_PARAM_set1_ip_asc(wanted, host.c_str()) != 1 &&
      X509_VERIFY_PARAM_set1_host(wanted, host.c_str(), host.size()) != 1) {
    return make_error(ErrorCode::kInvalidArgument, host + ": is no host's name");
  }
  SSL_CTX_set_verify(context, SSL_CTX_get_verify_mode(context), note_refusal);
  return {};
}

}  // namespace

std::string refused_certificate() {
  return last_refusal();
}

Result<std::unique_ptr<DcmTLSTransportLayer>> make_tls(const TlsFiles& files,
                                                       T_ASC_NetworkRole role,
                                                       const std::string& host) {
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
  if (!host.empty()) MOR_CHECK(expect_host(*layer, host));
  if (layer->activateCipherSuites().bad())
    return make_error(ErrorCode::kInternal, "TLS cannot be set up: no cipher suite");
  return layer;
}

}  // namespace mor::dimse
