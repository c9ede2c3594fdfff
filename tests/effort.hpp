// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d::test {

/// How many random cases a test draws of the `usual` number: four times as many with
/// RA2D_TEST_LONG (./test.sh --long), an eighth under sanitizers, whose faults do not hide in the
/// last bit.
int draws(int usual);

/// Whether they are enough to say what such cases are like on the whole.
bool draws_enough();

}  // namespace ra2d::test
