// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/main_loop.h"

#include <latch>
#include <utility>

#include <glib.h>

namespace mor {

namespace {

using Work = std::function<void()>;

void attach(GMainContext* context, GSource* source, GSourceFunc call, Work work) {
  g_source_set_callback(source, call, new Work(std::move(work)), [](gpointer data) {
    delete static_cast<Work*>(data);
  });
  g_source_attach(source, context);
  g_source_unref(source);
}

gboolean call_once(gpointer data) {
  (*static_cast<Work*>(data))();
  return G_SOURCE_REMOVE;
}

gboolean call_again(gpointer data) {
  (*static_cast<Work*>(data))();
  return G_SOURCE_CONTINUE;
}

}  // namespace

MainLoop::MainLoop() : context_(g_main_context_new()), loop_(g_main_loop_new(context_, FALSE)) {}

MainLoop::~MainLoop() {
  stop();
  g_main_loop_unref(loop_);
  g_main_context_unref(context_);
}

void MainLoop::run() {
  thread_ = std::jthread([this] {
    g_main_context_push_thread_default(context_);
    g_main_loop_run(loop_);
    g_main_context_pop_thread_default(context_);
  });
}

void MainLoop::stop() {
  if (!thread_.joinable()) return;
  // Posted, because a quit before the loop's first turn would be forgotten.
  post([this] { g_main_loop_quit(loop_); });
  thread_.join();
}

void MainLoop::post(std::function<void()> work) {
  GSource* source = g_idle_source_new();
  g_source_set_priority(source, G_PRIORITY_DEFAULT);
  attach(context_, source, call_once, std::move(work));
}

void MainLoop::post_and_wait(const std::function<void()>& work) {
  std::latch done(1);
  post([&] {
    work();
    done.count_down();
  });
  done.wait();
}

void MainLoop::every(std::chrono::milliseconds period, std::function<void()> work) {
  attach(context_,
         g_timeout_source_new(static_cast<guint>(period.count())),
         call_again,
         std::move(work));
}

}  // namespace mor
