#pragma once

#include <nanobind/nanobind.h>

namespace millscale::python {

void bind_similarity(nanobind::module_& m);
void bind_liner(nanobind::module_& m);
void bind_contact(nanobind::module_& m);

}  // namespace millscale::python
