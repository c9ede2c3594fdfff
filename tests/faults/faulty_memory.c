// SPDX-License-Identifier: BSD-3-Clause
// Memory that other programs take and give back. LD_PRELOAD the library that this is part of
// (faulty_disk), with in the environment
//   FAULTY_MEMORY   the file that is read for /proc/meminfo
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char* shown(const char* path) {
  const char* instead = getenv("FAULTY_MEMORY");
  return instead != NULL && strcmp(path, "/proc/meminfo") == 0 ? instead : path;
}

FILE* fopen(const char* path, const char* mode) {
  static FILE* (*real)(const char*, const char*);
  if (real == NULL) real = (FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, "fopen");
  return real(shown(path), mode);
}

FILE* fopen64(const char* path, const char* mode) {
  static FILE* (*real)(const char*, const char*);
  if (real == NULL) real = (FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, "fopen64");
  return real(shown(path), mode);
}
