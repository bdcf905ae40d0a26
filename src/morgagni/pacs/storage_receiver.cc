// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/storage_receiver.h"

#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <list>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include "morgagni/core/folder_lock.h"
#include "morgagni/core/log.h"
#include "morgagni/core/unique_fd.h"
#include "morgagni/pacs/dimse_protocol.h"
#include "morgagni/pacs/internal/dimse_process.h"
#include "morgagni/pacs/internal/dimse_task.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

struct Listener {
  UniqueFd socket;
  std::uint16_t port = 0;
};

Result<Listener> listen_on(const std::string& address, std::uint16_t port) {
  const auto failed = [&](const std::string& why) {
    return make_error(ErrorCode::kDevice,
                      fmt::format("cannot listen on {}:{}: {}", address, port, why));
  };
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found) != 0)
    return failed("not an address in numbers, as 127.0.0.1 or 0.0.0.0");
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> info(found, ::freeaddrinfo);
  Listener listener{UniqueFd(::socket(info->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0))};
  const int fd = listener.socket.get();
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  constexpr int kBacklog = 16;
  if (::bind(fd, info->ai_addr, info->ai_addrlen) != 0 || ::listen(fd, kBacklog) != 0)
    return failed(std::strerror(errno));
  sockaddr_in6 bound{};
  socklen_t length = sizeof(bound);
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &length);
  listener.port = ntohs(bound.sin6_port);  // In the same place of both families' addresses.
  return listener;
}

std::string host_of(const sockaddr_storage& address, socklen_t length) {
  std::array<char, NI_MAXHOST> host{};
  const int failure = ::getnameinfo(reinterpret_cast<const sockaddr*>(&address),
                                    length,
                                    host.data(),
                                    host.size(),
                                    nullptr,
                                    0,
                                    NI_NUMERICHOST);
  return failure == 0 ? host.data() : "?";
}

/// A-ASSOCIATE-RJ (PS3.8, 9.3.4): for now, by the presentation service, its limit is reached.
void reject_for_now(int socket) {
  constexpr std::array<unsigned char, 10> kRejection = {3, 0, 0, 0, 0, 4, 0, 2, 3, 2};
  (void)!::send(socket, kRejection.data(), kRejection.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

/// None where what the child says does not fit together.
std::optional<ReceivedObject> object_of(const fs::path& folder, const internal::TagValues& tags) {
  using namespace internal;
  ReceivedObject object{.uid = value_of(tags, tag::kSopInstanceUid),
                        .study_uid = value_of(tags, tag::kStudyUid),
                        .series_uid = value_of(tags, tag::kSeriesUid),
                        .modality = value_of(tags, tag::kModality),
                        .patient_id = value_of(tags, tag::kPatientId),
                        .study_date = value_of(tags, tag::kStudyDate),
                        .series_number = value_of(tags, tag::kSeriesNumber),
                        .series_description = value_of(tags, tag::kSeriesDescription)};
  if (!is_dicom_uid(object.uid) || !is_dicom_uid(object.study_uid) ||
      !is_dicom_uid(object.series_uid))
    return std::nullopt;
  object.file = folder / object.study_uid / object.series_uid / (object.uid + ".dcm");
  std::error_code status;
  if (!fs::is_regular_file(object.file, status)) return std::nullopt;
  return object;
}

fs::path parts_folder(const ReceiverOptions& options) {
  return options.folder / "parts";
}

nlohmann::json receive_task(const ReceiverOptions& options) {
  PacsOptions common{.aet = options.aet,
                     .timeout = options.idle_timeout,
                     .max_object_bytes = options.max_object_bytes,
                     .min_free_bytes = options.min_free_bytes};
  auto task = internal::dimse_task(dimse::kReceive, common);
  task["called_aet"] = options.aet;
  task["folder"] = options.folder.string();
  task["accepted_callers"] = options.accepted_callers;
  task["any_called_aet"] = options.any_called_aet;
  if (options.use_tls) task["tls"] = internal::dimse_tls(options.tls);
  return task;
}

class ProcessReceiver : public StorageReceiver {
 public:
  ProcessReceiver(ReceiverOptions options,
                  OnReceived on_received,
                  fs::path program,
                  FolderLock lock,
                  Listener listener,
                  UniqueFd wake)
      : options_(std::move(options)),
        on_received_(std::move(on_received)),
        program_(std::move(program)),
        lock_(std::move(lock)),
        listener_(std::move(listener)),
        wake_(std::move(wake)),
        task_(receive_task(options_)) {
    acceptor_ = std::jthread([this](const std::stop_token& stop) { accept_all(stop); });
  }

  ~ProcessReceiver() override {
    stop_accepting();
    stop_.request_stop();
    associations_.clear();  // Joins.
  }

  [[nodiscard]] std::uint16_t port() const override { return listener_.port; }

  void finish(std::chrono::seconds patience) override {
    stop_accepting();
    std::unique_lock lock(mutex_);
    ended_.wait_for(lock, patience, [this] { return num_running_ == 0; });
  }

 private:
  struct Association {
    bool is_over = false;  ///< Under `mutex_`.
    std::jthread thread;
  };

  void stop_accepting() {
    if (!acceptor_.joinable()) return;
    acceptor_.request_stop();
    const std::uint64_t one = 1;
    (void)!::write(wake_.get(), &one, sizeof(one));
    acceptor_.join();
    listener_.socket.reset();
  }

  void accept_all(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::array<pollfd, 2> waiting = {
          {{listener_.socket.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
      if (::poll(waiting.data(), waiting.size(), -1) <= 0 || waiting[0].revents == 0) continue;
      sockaddr_storage address{};
      socklen_t length = sizeof(address);
      UniqueFd socket(::accept4(
          listener_.socket.get(), reinterpret_cast<sockaddr*>(&address), &length, SOCK_CLOEXEC));
      if (socket.get() < 0) {
        // Out of descriptors: the connection stays in the queue, and would be seen again at once.
        if (errno == EMFILE || errno == ENFILE)
          std::this_thread::sleep_for(std::chrono::milliseconds(200));
        continue;
      }
      admit(std::move(socket), host_of(address, length));
    }
  }

  void admit(UniqueFd socket, const std::string& host) {
    const int on = 1;
    ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    ::setsockopt(socket.get(), SOL_SOCKET, SO_KEEPALIVE, &on, sizeof(on));
    std::list<Association> over;  // Joined after the lock is gone.
    const std::lock_guard lock(mutex_);
    for (auto at = associations_.begin(); at != associations_.end();) {
      const auto next = std::next(at);
      if (at->is_over) over.splice(over.end(), associations_, at);
      at = next;
    }
    if (num_running_ >= options_.max_associations) {
      log::warn("{}: refused, {} connections are open already", host, num_running_);
      reject_for_now(socket.get());
      return;
    }
    ++num_running_;
    auto& association = associations_.emplace_back();
    association.thread =
        std::jthread([this,
                      &association,
                      host,
                      parts = parts_folder(options_) / std::to_string(++num_admitted_),
                      socket = std::move(socket)]() mutable {
          serve(socket.get(), host, parts);
          socket.reset();
          const std::lock_guard end_lock(mutex_);
          association.is_over = true;
          --num_running_;
          ended_.notify_all();
        });
  }

  /// @param parts  What is not whole yet; its own folder.
  void serve(int socket, const std::string& host, const fs::path& parts) {
    std::error_code status;
    fs::create_directories(parts, status);
    auto task = task_;
    task["parts"] = parts.string();
    talk(task.dump(), socket, host);
    fs::remove_all(parts, status);
  }

  void talk(const std::string& task, int socket, const std::string& host) {
    std::string caller = host;
    int num_objects = 0;
    const internal::DimseEvents events{
        .stored =
            [&](const fs::path& /*file*/, const internal::TagValues& tags) {
              const auto object = object_of(options_.folder, tags);
              if (!object) return;
              ++num_objects;
              on_received_(*object);
            },
        .caller = [&](const std::string& aet) { caller = fmt::format("{} ({})", aet, host); },
        .refused = [&](const std::string& why) { log::warn("{}: {}", caller, why); }};
    const auto outcome = internal::run_dimse_process(
        program_,
        {.task = task, .socket_fd = socket, .peer = host, .time_limit = options_.max_duration},
        events,
        stop_.get_token());
    if (num_objects > 0) log::info("{}: {} objects received", caller, num_objects);
    if (!outcome && outcome.error().code != ErrorCode::kCancelled)
      log::warn("{}: {}", caller, outcome.error().message);
  }

  ReceiverOptions options_;
  OnReceived on_received_;
  fs::path program_;
  FolderLock lock_;
  Listener listener_;
  UniqueFd wake_;
  const nlohmann::json task_;
  std::stop_source stop_;
  std::mutex mutex_;
  std::condition_variable ended_;
  int num_running_ = 0;
  std::uint64_t num_admitted_ = 0;
  std::list<Association> associations_;
  std::jthread acceptor_;
};

}  // namespace

Result<void> ReceiverOptions::check() const {
  MOR_CHECK(check_aet(aet, "--aet"));
  for (const auto& caller : accepted_callers) MOR_CHECK(check_aet(caller, "--accept"));
  if (max_associations < 1 || max_associations > 64) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("--max-associations must be 1 to 64, got {}", max_associations));
  }
  if (use_tls && (tls.certificate.empty() || tls.key.empty())) {
    return make_error(ErrorCode::kInvalidArgument,
                      "TLS needs --certificate and --key: who receives shows a certificate");
  }
  return {};
}

Result<std::unique_ptr<StorageReceiver>> StorageReceiver::start(const ReceiverOptions& options,
                                                                OnReceived on_received) {
  MOR_CHECK(options.check());
  MOR_CHECK(internal::dimse_text(receive_task(options)));
  MOR_TRY(auto program, internal::find_dimse_program());
  MOR_TRY(auto lock,
          FolderLock::make_and_take(
              options.folder,
              FolderLock::Kind::kExclusive,
              options.folder.string() + ": another receiver writes into this folder already"));
  std::error_code status;
  fs::remove_all(parts_folder(options), status);  // Of a run that was killed.
  MOR_TRY(auto listener, listen_on(options.listen_address, options.port));
  UniqueFd wake(::eventfd(0, EFD_CLOEXEC));
  if (wake.get() < 0) return make_error(ErrorCode::kDevice, "too many open files");
  return std::make_unique<ProcessReceiver>(options,
                                           std::move(on_received),
                                           std::move(program),
                                           std::move(lock),
                                           std::move(listener),
                                           std::move(wake));
}

}  // namespace mor
