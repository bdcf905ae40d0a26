// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace mor {

/// From now on the program keeps what it frees, in pieces of up to 32 MB, for what it asks for next.
/// The masks of a CT, 10 MB each, come and go by the hundred, and fresh pages from the system can
/// cost more than the work on them. For a program that ends when its work is done.
void keep_freed_memory();

}  // namespace mor
