// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// toml++, with its internal assertions off. Some malformed texts, such as a header "[[[a]]]",
/// break one right before the check that reports them as a syntax error: a debug build would abort
/// there, and a release build by clang would take the assertion for granted.
#pragma push_macro("NDEBUG")
#undef NDEBUG  // under which the next line would have no effect
#define TOML_ASSERT(expr) static_assert(true)
/// Arrays and inline tables in one another; dotted keys are counted before toml++ sees them (reader.cpp).
#define TOML_MAX_NESTED_VALUES 32
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")
