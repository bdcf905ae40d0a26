// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/viewer.h"

#include <utility>

#include <gst/app/gstappsrc.h>
#include <gst/video/video.h>
#include <nice/agent.h>
#include <nlohmann/json.hpp>

#include "morgagni/core/log.h"
#include "morgagni/stream/internal/gst_parts.h"

namespace mor::internal {

namespace {

// More pictures than this waiting for one viewer: its path is stuck.
constexpr guint64 kMaxWaitingPictures = 4;
// A stopped browser must not fill our memory through its data channel.
constexpr guint64 kMaxWaitingMessageBytes = 64 * 1024;
constexpr std::chrono::seconds kConnectLimit{15};
constexpr std::chrono::seconds kSilenceLimit{15};
constexpr std::size_t kMaxMessageBytes = 256;

/// What went wrong in a step of the negotiation; empty: nothing.
std::string error_in(bool has_reply, const GstStructure* reply) {
  if (!has_reply) return "the connection was closed";
  if (reply == nullptr || !gst_structure_has_field(reply, "error")) return {};
  GError* raw = nullptr;
  gst_structure_get(reply, "error", G_TYPE_ERROR, &raw, nullptr);
  const GErrorHandle error(raw);
  return error ? error->message : "webrtcbin gives no reason";
}

}  // namespace

double server_ms(Viewer::Clock::time_point time) {
  return std::chrono::duration<double, std::milli>(time.time_since_epoch()).count();
}

Viewer::Viewer(MainLoop& main_loop, std::function<void()> on_key_wanted)
    : main_loop_(main_loop), on_key_wanted_(std::move(on_key_wanted)) {}

Viewer::~Viewer() {
  close();
}

Result<std::shared_ptr<Viewer>> Viewer::create(MainLoop& main_loop,
                                               GstElement* timing,
                                               int vp8_payload_type,
                                               std::function<void()> on_key_wanted) {
  std::shared_ptr<Viewer> viewer(new Viewer(main_loop, std::move(on_key_wanted)));
  MOR_CHECK(viewer->build(timing, vp8_payload_type));
  return viewer;
}

/// webrtcbin's signals come on threads of its own: what they mean is done in the main loop, if the
/// viewer is still there.
void Viewer::on_change_of(const char* property, void (Viewer::*handler)()) {
  struct Binding {
    MainLoop& main_loop;
    std::weak_ptr<Viewer> viewer;
    void (Viewer::*handler)();
  };
  const auto call = +[](gpointer, GParamSpec*, gpointer data) {
    const auto& binding = *static_cast<Binding*>(data);
    binding.main_loop.post([viewer = binding.viewer, handler = binding.handler] {
      if (const auto self = viewer.lock(); self && self->pipeline_) (self.get()->*handler)();
    });
  };
  g_signal_connect_data(
      webrtc_,
      (std::string("notify::") + property).c_str(),
      G_CALLBACK(call),
      new Binding{main_loop_, weak_from_this(), handler},
      [](gpointer data, GClosure*) { delete static_cast<Binding*>(data); },
      GConnectFlags(0));
}

Result<GstElement*> Viewer::add_payloader(int vp8_payload_type) {
  GstBin* bin = GST_BIN(pipeline_.get());
  MOR_TRY(GstElement* const payloader, add_part(bin, "rtpvp8pay"));
  MOR_TRY(GstElement* const filter, add_part(bin, "capsfilter"));
  // No offset: the browser's rtpTimestamp is then our stamp, which ties a message to its picture.
  g_object_set(payloader,
               "pt",
               static_cast<guint>(vp8_payload_type),
               "timestamp-offset",
               0U,
               "mtu",
               1200U,
               nullptr);
  gst_util_set_object_arg(G_OBJECT(payloader), "picture-id-mode", "15-bit");
  const GstCapsHandle caps(gst_caps_new_simple("application/x-rtp",
                                               "media",
                                               G_TYPE_STRING,
                                               "video",
                                               "encoding-name",
                                               G_TYPE_STRING,
                                               "VP8",
                                               "clock-rate",
                                               G_TYPE_INT,
                                               90000,
                                               "payload",
                                               G_TYPE_INT,
                                               vp8_payload_type,
                                               nullptr));
  g_object_set(filter, "caps", caps.get(), nullptr);
  gst_element_link_many(source_.get(), payloader, filter, nullptr);
  return filter;
}

Result<void> Viewer::build(GstElement* timing, int vp8_payload_type) {
  pipeline_.reset(GST_ELEMENT(gst_object_ref_sink(gst_pipeline_new(nullptr))));
  GstBin* bin = GST_BIN(pipeline_.get());
  MOR_TRY(GstElement* const source, add_part(bin, "appsrc"));
  source_.reset(GST_ELEMENT(gst_object_ref(source)));
  const GstCapsHandle caps(gst_caps_new_empty_simple("video/x-vp8"));
  g_object_set(source, "is-live", TRUE, "format", GST_FORMAT_TIME, "caps", caps.get(), nullptr);
  MOR_TRY(GstElement* const payloader, add_payloader(vp8_payload_type));
  MOR_TRY(webrtc_, add_part(bin, "webrtcbin"));
  gst_util_set_object_arg(G_OBJECT(webrtc_), "bundle-policy", "max-bundle");
  gst_element_link(payloader, webrtc_);
  GstWebRTCRTPTransceiver* transceiver = nullptr;
  g_signal_emit_by_name(webrtc_, "get-transceiver", 0, &transceiver);
  if (transceiver == nullptr) {
    return make_error(ErrorCode::kInternal, "webrtcbin has no place for the video");
  }
  g_object_set(transceiver, "direction", GST_WEBRTC_RTP_TRANSCEIVER_DIRECTION_SENDONLY, nullptr);
  gst_object_unref(transceiver);

  const GstHandle<GstClock> clock(gst_element_get_clock(timing));
  gst_pipeline_use_clock(GST_PIPELINE(pipeline_.get()), clock.get());
  gst_element_set_start_time(pipeline_.get(), GST_CLOCK_TIME_NONE);
  gst_element_set_base_time(pipeline_.get(), gst_element_get_base_time(timing));
  stay_on_loopback();
  watch();
  if (gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE) {
    return make_error(ErrorCode::kDevice, "webrtcbin does not start");
  }
  return {};
}

void Viewer::stay_on_loopback() {
  GObject* ice = nullptr;
  g_object_get(webrtc_, "ice-agent", &ice, nullptr);
  const GObjectHandle<GObject> ice_owner(ice);
  NiceAgent* agent = nullptr;
  g_object_get(ice, "agent", &agent, nullptr);
  const GObjectHandle<NiceAgent> agent_owner(agent);
  NiceAddress loopback;
  nice_address_init(&loopback);
  nice_address_set_from_string(&loopback, "127.0.0.1");
  nice_agent_add_local_address(agent, &loopback);
  // The checks that keep a connection alive also tell when nobody answers them any more.
  g_object_set(agent, "upnp", FALSE, "ice-tcp", FALSE, "keepalive-conncheck", TRUE, nullptr);
}

void Viewer::watch() {
  on_change_of("ice-gathering-state", &Viewer::on_gathering_changed);
  on_change_of("connection-state", &Viewer::on_connection_changed);
  using Weak = std::weak_ptr<Viewer>;
  const auto free_weak = [](gpointer data, GClosure*) { delete static_cast<Weak*>(data); };
  const auto channel_opened = +[](GstElement*, GstWebRTCDataChannel* channel, gpointer data) {
    if (const auto self = static_cast<Weak*>(data)->lock()) self->on_channel(channel);
  };
  g_signal_connect_data(webrtc_,
                        "on-data-channel",
                        G_CALLBACK(channel_opened),
                        new Weak(weak_from_this()),
                        free_weak,
                        GConnectFlags(0));
  const GstHandle<GstPad> output(gst_element_get_static_pad(source_.get(), "src"));
  // A browser that lost pictures asks for a key picture: the event travels up to here.
  gst_pad_add_probe(
      output.get(),
      GST_PAD_PROBE_TYPE_EVENT_UPSTREAM,
      [](GstPad*, GstPadProbeInfo* info, gpointer data) {
        if (gst_video_event_is_force_key_unit(GST_PAD_PROBE_INFO_EVENT(info))) {
          if (const auto self = static_cast<Weak*>(data)->lock()) self->on_key_wanted_();
        }
        return GST_PAD_PROBE_OK;
      },
      new Weak(weak_from_this()),
      [](gpointer data) { delete static_cast<Weak*>(data); });
  // Whether the viewer lives is told by its connection; messages would only pile up unread.
  const GstHandle<GstBus> bus(gst_element_get_bus(pipeline_.get()));
  gst_bus_set_sync_handler(
      bus.get(),
      [](GstBus*, GstMessage* message, gpointer) {
        gst_message_unref(message);
        return GST_BUS_DROP;
      },
      nullptr,
      nullptr);
}

/// Starts one step of webrtcbin's negotiation; `next` gets its reply in the main loop.
void Viewer::after(const std::function<void(GstPromise*)>& step,
                   std::function<void(Viewer&, const GstStructure*)> next) {
  struct Binding {
    MainLoop& main_loop;
    std::weak_ptr<Viewer> viewer;
    std::function<void(Viewer&, const GstStructure*)> next;
  };
  const auto replied = [](GstPromise* promise, gpointer data) {
    const auto& binding = *static_cast<Binding*>(data);
    const std::shared_ptr<GstPromise> kept(gst_promise_ref(promise), gst_promise_unref);
    binding.main_loop.post([kept, viewer = binding.viewer, next = binding.next] {
      const auto self = viewer.lock();
      if (!self || !self->pipeline_) return;
      const bool has_reply = gst_promise_wait(kept.get()) == GST_PROMISE_RESULT_REPLIED;
      const GstStructure* reply = has_reply ? gst_promise_get_reply(kept.get()) : nullptr;
      if (const std::string reason = error_in(has_reply, reply); !reason.empty()) {
        self->finish_answer(
            make_error(ErrorCode::kInvalidArgument, "the offer cannot be answered: " + reason));
        return;
      }
      next(*self, reply);
    });
  };
  GstPromise* promise = gst_promise_new_with_change_func(
      replied, new Binding{main_loop_, weak_from_this(), std::move(next)}, [](gpointer data) {
        delete static_cast<Binding*>(data);
      });
  step(promise);
  gst_promise_unref(promise);
}

void Viewer::answer(SdpHandle offer, Answered answered) {
  answered_ = std::move(answered);
  const std::shared_ptr<GstWebRTCSessionDescription> description(
      gst_webrtc_session_description_new(GST_WEBRTC_SDP_TYPE_OFFER, offer.release()),
      gst_webrtc_session_description_free);
  after(
      [&](GstPromise* promise) {
        g_signal_emit_by_name(webrtc_, "set-remote-description", description.get(), promise);
      },
      [](Viewer& self, const GstStructure*) { self.create_answer(); });
}

void Viewer::create_answer() {
  after(
      [this](GstPromise* promise) {
        g_signal_emit_by_name(webrtc_, "create-answer", nullptr, promise);
      },
      [](Viewer& self, const GstStructure* reply) { self.adopt_answer(reply); });
}

void Viewer::adopt_answer(const GstStructure* reply) {
  GstWebRTCSessionDescription* raw = nullptr;
  if (reply != nullptr) {
    gst_structure_get(reply, "answer", GST_TYPE_WEBRTC_SESSION_DESCRIPTION, &raw, nullptr);
  }
  if (raw == nullptr) {
    finish_answer(make_error(ErrorCode::kInvalidArgument, "the offer cannot be answered"));
    return;
  }
  const std::shared_ptr<GstWebRTCSessionDescription> description(
      raw, gst_webrtc_session_description_free);
  after(
      [&](GstPromise* promise) {
        g_signal_emit_by_name(webrtc_, "set-local-description", description.get(), promise);
      },
      [](Viewer& self, const GstStructure*) { self.on_gathering_changed(); });
}

void Viewer::on_gathering_changed() {
  if (!answered_) return;
  GstWebRTCICEGatheringState state{};
  GstWebRTCSessionDescription* local = nullptr;
  g_object_get(webrtc_, "ice-gathering-state", &state, "local-description", &local, nullptr);
  const std::shared_ptr<GstWebRTCSessionDescription> owner(
      local, [](GstWebRTCSessionDescription* description) {
        if (description != nullptr) gst_webrtc_session_description_free(description);
      });
  // WHEP has one answer and no trickle: it must hold the addresses.
  if (state != GST_WEBRTC_ICE_GATHERING_STATE_COMPLETE || local == nullptr) return;
  const GCharHandle text(gst_sdp_message_as_text(local->sdp));
  finish_answer(std::string(text.get()));
}

void Viewer::finish_answer(Result<std::string> result) {
  if (!result) has_failed_ = true;
  if (const auto answered = std::exchange(answered_, nullptr)) answered(std::move(result));
}

void Viewer::on_connection_changed() {
  GstWebRTCPeerConnectionState state{};
  g_object_get(webrtc_, "connection-state", &state, nullptr);
  switch (state) {
    case GST_WEBRTC_PEER_CONNECTION_STATE_CONNECTED:
      if (!is_connected_.exchange(true)) on_key_wanted_();
      break;
    case GST_WEBRTC_PEER_CONNECTION_STATE_FAILED:
    case GST_WEBRTC_PEER_CONNECTION_STATE_CLOSED:
      has_failed_ = true;
      break;
    default:
      break;
  }
}

void Viewer::on_channel(GstWebRTCDataChannel* channel) {
  struct Binding {
    MainLoop& main_loop;
    std::weak_ptr<Viewer> viewer;
  };
  const auto received = +[](GstWebRTCDataChannel*, const char* text, gpointer data) {
    if (text == nullptr) return;
    const auto& binding = *static_cast<Binding*>(data);
    binding.main_loop.post([viewer = binding.viewer, message = std::string(text)] {
      if (const auto self = viewer.lock(); self && self->pipeline_) self->on_message(message);
    });
  };
  const std::lock_guard lock(mutex_);
  if (channel_) return;
  channel_.reset(GST_WEBRTC_DATA_CHANNEL(g_object_ref(channel)));
  heard_at_ = Clock::now();
  g_signal_connect_data(
      channel,
      "on-message-string",
      G_CALLBACK(received),
      new Binding{main_loop_, weak_from_this()},
      [](gpointer data, GClosure*) { delete static_cast<Binding*>(data); },
      GConnectFlags(0));
}

/// The page's heartbeat, `{"ping": t}`: the answer lets it relate its clock to ours, so that the
/// latency it shows is measured and not guessed.
void Viewer::on_message(const std::string& text) {
  {
    const std::lock_guard lock(mutex_);
    heard_at_ = Clock::now();
  }
  if (text.size() > kMaxMessageBytes) return;
  const auto message = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!message.is_object() || !message.contains("ping") || !message["ping"].is_number()) return;
  send_message(
      nlohmann::json{{"pong", message["ping"]}, {"server_ms", server_ms(Clock::now())}}.dump());
}

void Viewer::send_message(const std::string& text) {
  GObjectHandle<GstWebRTCDataChannel> channel;
  {
    const std::lock_guard lock(mutex_);
    if (!channel_) return;
    channel.reset(GST_WEBRTC_DATA_CHANNEL(g_object_ref(channel_.get())));
  }
  guint64 waiting_bytes = 0;
  GstWebRTCDataChannelState state{};
  g_object_get(channel.get(), "buffered-amount", &waiting_bytes, "ready-state", &state, nullptr);
  if (state != GST_WEBRTC_DATA_CHANNEL_STATE_OPEN || waiting_bytes > kMaxWaitingMessageBytes) {
    return;
  }
  gst_webrtc_data_channel_send_string_full(channel.get(), text.c_str(), nullptr);
}

void Viewer::send(const EncodedPicture& picture, const std::string& message) {
  if (!is_connected_) return;
  GstAppSrc* source = GST_APP_SRC(source_.get());
  if (gst_app_src_get_current_level_buffers(source) >= kMaxWaitingPictures) {
    is_waiting_for_key_ = true;
    return;
  }
  if (is_waiting_for_key_ && !picture.is_key) {
    on_key_wanted_();
    return;
  }
  is_waiting_for_key_ = false;
  send_message(message);
  gst_app_src_push_buffer(source, gst_buffer_ref(picture.buffer));
}

bool Viewer::is_gone(Clock::time_point now) const {
  if (has_failed_) return true;
  if (!is_connected_) return now - created_at_ > kConnectLimit;
  const std::lock_guard lock(mutex_);
  return channel_ && now - heard_at_ > kSilenceLimit;
}

void Viewer::close() {
  if (!pipeline_) return;
  is_connected_ = false;
  finish_answer(make_error(ErrorCode::kCancelled, "the connection was closed"));
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  webrtc_ = nullptr;
  pipeline_.reset();
  const std::lock_guard lock(mutex_);
  channel_.reset();
}

}  // namespace mor::internal
