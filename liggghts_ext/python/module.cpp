#include "python/bindings.h"

NB_MODULE(_core, m)
{
  // Objects that live until the interpreter ends, such as test parameters, are no leak.
  nanobind::set_leak_warnings(false);
  m.doc() =
      "Similarity law, lifter-liner cross-section and contact limits of ball mills. SI units; "
      "wrong "
      "input raises ValueError with the value and the accepted range. Mill axis y, gravity -z; "
      "polar "
      "angles are measured from the bottom in the direction of rotation (bottom moves to -x).";
  millscale::python::bind_similarity(m);
  millscale::python::bind_liner(m);
  millscale::python::bind_contact(m);
}
