#pragma once

#include "core/math/vector.h"

namespace millscale {

/// A vector in space whose components are numbers or packs of numbers.
template <class Number>
struct Vector3 {
  Number x, y, z;
};

template <class Number>
inline Vector3<Number> operator+(const Vector3<Number>& a, const Vector3<Number>& b)
{
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Number>
inline Vector3<Number> operator-(const Vector3<Number>& a, const Vector3<Number>& b)
{
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Number>
inline Vector3<Number> operator*(const Number& s, const Vector3<Number>& a)
{
  return {s * a.x, s * a.y, s * a.z};
}
/// Return a + s b, whose components packs round once.
template <class Number>
inline Vector3<Number> add_scaled(const Vector3<Number>& a, const Number& s,
                                  const Vector3<Number>& b)
{
  return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
/// Return a - s b, whose components packs round once.
template <class Number>
inline Vector3<Number> subtract_scaled(const Vector3<Number>& a, const Number& s,
                                       const Vector3<Number>& b)
{
  return {a.x - s * b.x, a.y - s * b.y, a.z - s * b.z};
}
template <class Number>
inline Number dot(const Vector3<Number>& a, const Vector3<Number>& b)
{
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Number>
inline Vector3<Number> cross(const Vector3<Number>& a, const Vector3<Number>& b)
{
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline Vector3<double> vector3(const Vector& a)
{
  return {a[0], a[1], a[2]};
}
inline Vector3<double> vector3(const double* a)
{
  return {a[0], a[1], a[2]};
}
inline Vector to_array(const Vector3<double>& a)
{
  return {a.x, a.y, a.z};
}

}  // namespace millscale
