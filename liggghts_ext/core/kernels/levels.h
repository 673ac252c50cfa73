#pragma once

#include "core/kernels/kernel.h"

/// The functions of the implementations. Those of v3 and v4 are the same sources, compiled twice.
namespace millscale::kernels {

namespace v2 {
extern const WallKernels wall;
void evaluate(const Task&);
}  // namespace v2
namespace v3 {
extern const WallKernels wall;
Advanced advance(const Advance&);
void evaluate(const Task&);
void evaluate_mixed(const Task&);
void evaluate_rows(const Task&);
void evaluate_rows_mixed(const Task&);
}  // namespace v3
namespace v4 {
extern const WallKernels wall;
Advanced advance(const Advance&);
void evaluate(const Task&);
void evaluate_mixed(const Task&);
void evaluate_rows(const Task&);
void evaluate_rows_mixed(const Task&);
}  // namespace v4

}  // namespace millscale::kernels
