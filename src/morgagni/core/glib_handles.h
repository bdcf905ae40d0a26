// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <glib-object.h>

namespace mor {

template <auto Free>
struct FreeWith {
  template <class T>
  void operator()(T* pointer) const {
    Free(pointer);
  }
};

template <class T>
using GObjectHandle = std::unique_ptr<T, FreeWith<g_object_unref>>;
using GErrorHandle = std::unique_ptr<GError, FreeWith<g_error_free>>;
using GCharHandle = std::unique_ptr<char, FreeWith<g_free>>;

}  // namespace mor
