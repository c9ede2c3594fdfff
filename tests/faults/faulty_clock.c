// SPDX-License-Identifier: BSD-3-Clause
// Sets the wall clock, as its user or a time server may. LD_PRELOAD the library that this is part of
// (faulty_disk), with in the environment
//   FAULTY_CLOCK   seconds by which the wall clock is set: forward, back, back and forward again, one after
//                  the other each time it is read. Clocks that nobody can set stay as they are.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>

static atomic_uint readings;

static time_t set_by(void) {
  static const int turns[] = {0, 1, 0, -1};
  const char* jump = getenv("FAULTY_CLOCK");
  return jump == NULL ? 0 : turns[readings++ % 4] * atol(jump);
}

int clock_gettime(clockid_t clock, struct timespec* now) {
  static int (*real)(clockid_t, struct timespec*);
  if (real == NULL) real = (int (*)(clockid_t, struct timespec*))dlsym(RTLD_NEXT, "clock_gettime");
  const int status = real(clock, now);
  if (status == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE))
    now->tv_sec += set_by();
  return status;
}

time_t time(time_t* now) {
  struct timespec read;
  clock_gettime(CLOCK_REALTIME, &read);
  if (now != NULL) *now = read.tv_sec;
  return read.tv_sec;
}

int gettimeofday(struct timeval* restrict now, void* restrict zone) {
  (void)zone;
  struct timespec read;
  clock_gettime(CLOCK_REALTIME, &read);
  now->tv_sec = read.tv_sec;
  now->tv_usec = read.tv_nsec / 1000;
  return 0;
}
