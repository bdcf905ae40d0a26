// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What `morgagni` and `morgagni-dimse`, its process for one DICOM connection, say to each other.
///
/// The parent writes one JSON object to the child's standard input: the task. The child answers
/// with one JSON object a line on standard output: any number of events, then `done` or `failed`.
/// It parses what a stranger sends and may die without harm; the parent believes none of it.
namespace mor::dimse {

inline constexpr const char* kProgramName = "morgagni-dimse";

/// Tasks.
inline constexpr const char* kEcho = "echo";        ///< C-ECHO.
inline constexpr const char* kFind = "find";        ///< C-FIND.
inline constexpr const char* kGet = "get";          ///< C-GET.
inline constexpr const char* kMove = "move";        ///< C-MOVE; others receive what it sends.
inline constexpr const char* kReceive = "receive";  ///< Serves the connection that is open already.

/// Events.
inline constexpr const char* kMatch = "match";      ///< An object: tag ("0020000D") -> text.
inline constexpr const char* kStored = "stored";    ///< "file", "bytes", "tags".
inline constexpr const char* kCaller = "caller";    ///< AE title of who connected.
inline constexpr const char* kRefused = "refused";  ///< Why something that was sent was not taken.
inline constexpr const char* kWeakness = "weakness";  ///< A limit that this machine does not have.
inline constexpr const char* kDone = "done";          ///< Sub-operations that "failed", if any.
inline constexpr const char* kFailed = "failed";      ///< A sentence, with the error's "code".

/// The connection of `receive`, by number.
inline constexpr int kSocketFd = 3;
inline constexpr int kMaxLineBytes = 65536;

}  // namespace mor::dimse
