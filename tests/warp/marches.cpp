// SPDX-License-Identifier: BSD-3-Clause
#include "tests/warp/marches.hpp"

namespace ra2d::test {
namespace {

template <class Use>
void with_form(Form form, const Use& use) {
  switch (form) {
    case Form::semi_implicit:
      return use.template operator()<Form::semi_implicit>();
    case Form::staged:
      return use.template operator()<Form::staged>();
    case Form::implicit:
      return use.template operator()<Form::implicit>();
    case Form::adaptive:
      return use.template operator()<Form::adaptive>();
  }
}

}  // namespace

void march_on_pack(int packs, const SceneTables& tables, SceneState& state, std::int64_t target) {
  with_form(tables.scheme.form,
            [&]<Form form>() { march_form_on_pack<form>(packs, tables, state, target); });
}

void march_on_warp(Warp& warp, int packs, const SceneTables& tables, SceneState& state,
                   std::int64_t target) {
  with_form(tables.scheme.form,
            [&]<Form form>() { march_form_on_warp<form>(warp, packs, tables, state, target); });
}

}  // namespace ra2d::test
