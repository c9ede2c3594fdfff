// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d {

/// From now on SIGINT, SIGQUIT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU and the timers' SIGALRM,
/// SIGVTALRM and SIGPROF end the program with the status 128 + n and without a partial file or a
/// child process left: at once, wherever it is, but for a run that marches
/// (host/system/interruption.hpp), which writes what it has first. There it is the second one that
/// ends it at once. A SIGHUP that is ignored, as under nohup, stays ignored, and a profiler keeps
/// its SIGPROF. A write to a pipe that nobody reads any more fails instead of ending the program
/// (SIGPIPE).
void catch_interrupts();

/// A signal that ends the program at once says these words from now on, not "interrupted" alone.
void say_when_interrupted(const char* words);

/// Has SIGUSR1 end the process like the others, also one that came before: of a command that keeps
/// no checkpoints. Of others it is ignored as long as there is none to keep.
void end_at_checkpoint_signal();

}  // namespace ra2d
