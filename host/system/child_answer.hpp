// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <string>

namespace ra2d {

/// The answer of a child process, or how it ended without one.
struct ChildAnswer {
  bool started = true;  // false: the system started no process
  std::string text;
  std::string fault;  // "ended by signal 11 (Segmentation fault)"; empty where it has answered
};

/// Runs `ask` in a child process: for libraries that may crash on hostile bytes, or never end. The
/// child may take so many bytes of memory more than this process has, and so many seconds of
/// processor time. Only its answer arrives: what it prints is lost. It does not outlive this
/// process.
ChildAnswer ask_in_child(const std::function<std::string()>& ask, double memory, double seconds);

}  // namespace ra2d
