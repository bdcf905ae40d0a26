// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/skin_check.h"

#include <utility>

#include "morgagni/session/skin_check_desk.h"

namespace mor {
namespace {

class Check final : public SkinCheck {
 public:
  Check(std::shared_ptr<SkinCheckDesk> desk, std::unique_ptr<LiveServer> server)
      : desk_(std::move(desk)), server_(std::move(server)) {}

  std::uint16_t port() const override { return server_->port(); }
  std::optional<PrepareSummary> wait(std::stop_token stop) override {
    return desk_->wait(std::move(stop));
  }

 private:
  std::shared_ptr<SkinCheckDesk> desk_;
  std::unique_ptr<LiveServer> server_;
};

std::vector<HttpRoute> routes_of(const std::shared_ptr<SkinCheckDesk>& desk) {
  return {api::get("/api/check", [=](const HttpRequest&) { return api::answer(desk->state()); }),
          api::post("/api/check/change", [=](const auto& text) { return desk->change(text); }),
          api::post("/api/check/use", [=](const auto&) { return desk->use(); }),
          api::post("/api/check/cancel", [=](const auto&) { return desk->cancel(); }),
          api::get("/api/check/slice.png", [=](const HttpRequest& r) { return desk->slice(r); }),
          api::get("/api/check/surface", [=](const HttpRequest& r) { return desk->surface(r); })};
}

}  // namespace

Result<std::unique_ptr<SkinCheck>> SkinCheck::start(std::shared_ptr<const Volume> volume,
                                                    UseBody use,
                                                    const SkinCheckOptions& options) {
  const auto desk = std::make_shared<SkinCheckDesk>(std::move(volume), std::move(use), options);
  MOR_CHECK(desk->begin());
  MOR_TRY(auto server, LiveServer::start(options.server, routes_of(desk)));
  return std::make_unique<Check>(desk, std::move(server));
}

}  // namespace mor
