#pragma once

// Packs of numbers for the kernels of x86-64-v3 and v4; MILLSCALE_LEVEL is v3 or v4. Everything in
// this file and in those that include it is local to the object file, and calls no library. A
// function shared between object files could be linked from one of these, and would then run on a
// machine that lacks its instructions.
#include <immintrin.h>

#include <type_traits>

#include "core/kernels/levels.h"

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

inline double fma_of(double a, double b, double c)
{
  return __builtin_fma(a, b, c);
}
inline float fma_of(float a, float b, float c)
{
  return __builtin_fmaf(a, b, c);
}

/// The product of two packs, not yet rounded. Its sum with another number is rounded once. That the
/// source decides which sums are fused, not the compiler, gives all objects the same bits.
template <class Number>
struct Product {
  Number a, b;

  operator Number() const { return rounded(a, b); }
  friend Number operator+(Product p, Number c) { return fused(p.a, p.b, c); }
  friend Number operator+(Number c, Product p) { return fused(p.a, p.b, c); }
  friend Number operator+(Product p, Product q) { return fused(q.a, q.b, p); }
  friend Number operator-(Product p, Number c) { return fused(p.a, p.b, negated(c)); }
  friend Number operator-(Number c, Product p) { return fused(negated(p.a), p.b, c); }
  friend Number operator-(Product p, Product q) { return fused(negated(q.a), q.b, p); }
};

/// One number of each of several contacts: the compiler's vector type with the functions that
/// `contact::contact_force` needs.
template <class Scalar, int count>
struct Pack {
  static constexpr int lanes = count;
  typedef Scalar Values __attribute__((vector_size(count * sizeof(Scalar))));
  using Mask = decltype(Values{} > Values{});

  Values values;

  Pack() = default;
  // Copies that are written out keep the compiler from copying vectors of packs as bytes.
  Pack(const Pack& other) : values(other.values) {}
  Pack& operator=(const Pack& other)
  {
    values = other.values;
    return *this;
  }
  explicit Pack(double all) : values(Values{} + static_cast<Scalar>(all)) {}
  template <class Register>
  static Pack of(Register v)
  {
    Pack pack;
    pack.values = Values(v);
    return pack;
  }

  friend Pack operator+(Pack a, Pack b) { return of(a.values + b.values); }
  friend Pack operator-(Pack a, Pack b) { return of(a.values - b.values); }
  friend Product<Pack> operator*(Pack a, Pack b) { return {a, b}; }
  friend Pack operator/(Pack a, Pack b) { return of(a.values / b.values); }
  friend Mask operator>(Pack a, Pack b) { return a.values > b.values; }
  friend Pack choose(Mask condition, Pack yes, Pack no)
  {
    return of(condition ? yes.values : no.values);
  }
  friend Pack rounded(Pack a, Pack b) { return of(a.values * b.values); }
  friend Pack negated(Pack a) { return of(-a.values); }
  friend Pack fused(Pack a, Pack b, Pack c)
  {
    Pack sum;
    for (int lane = 0; lane < count; ++lane)
      sum.values[lane] = fma_of(a.values[lane], b.values[lane], c.values[lane]);
    return sum;
  }
  friend Pack abs(Pack a) { return of(a.values < Values{} ? -a.values : a.values); }
};

template <class Scalar, int count>
inline Pack<Scalar, count> sqrt(Pack<Scalar, count> a)
{
  Pack<Scalar, count> root;
  for (int lane = 0; lane < count; ++lane) root.values[lane] = __builtin_sqrt(a.values[lane]);
  return root;
}

/// Two packs side by side: while one waits for a root or a quotient, the other goes on.
template <class PackOfHalf>
struct Two {
  using Half = PackOfHalf;
  static constexpr int lanes = 2 * Half::lanes;
  struct Mask {
    typename Half::Mask first, second;
  };
  Half first, second;

  Two() = default;
  Two(Half a, Half b) : first(a), second(b) {}
  explicit Two(double all) : first(all), second(all) {}

  friend Two operator+(Two a, Two b) { return {a.first + b.first, a.second + b.second}; }
  friend Two operator-(Two a, Two b) { return {a.first - b.first, a.second - b.second}; }
  friend Product<Two> operator*(Two a, Two b) { return {a, b}; }
  friend Two operator/(Two a, Two b) { return {a.first / b.first, a.second / b.second}; }
  friend Mask operator>(Two a, Two b) { return {a.first > b.first, a.second > b.second}; }
  friend Two choose(Mask condition, Two yes, Two no)
  {
    return {choose(condition.first, yes.first, no.first),
            choose(condition.second, yes.second, no.second)};
  }
  friend Two rounded(Two a, Two b)
  {
    return {rounded(a.first, b.first), rounded(a.second, b.second)};
  }
  friend Two negated(Two a) { return {negated(a.first), negated(a.second)}; }
  friend Two fused(Two a, Two b, Two c)
  {
    return {fused(a.first, b.first, c.first), fused(a.second, b.second, c.second)};
  }
  friend Two abs(Two a) { return {abs(a.first), abs(a.second)}; }
  friend Two sqrt(Two a) { return {sqrt(a.first), sqrt(a.second)}; }
};

/// x, y, z and a fourth number of contacts.
template <class Number>
struct Columns {
  Vector3<Number> xyz;
  Number fourth;
};

/// The velocity rows of a ball of each contact.
template <class Number>
struct Velocities {
  Columns<Number> velocity, spin;  ///< and mass, and share in the damping divisor
};

/// Return both halves side by side.
template <class Half>
inline Two<Half> two(Half first, Half second)
{
  return {first, second};
}
template <class Half>
inline Vector3<Two<Half>> two(const Vector3<Half>& first, const Vector3<Half>& second)
{
  return {two(first.x, second.x), two(first.y, second.y), two(first.z, second.z)};
}
template <class Half>
inline Columns<Two<Half>> two(const Columns<Half>& first, const Columns<Half>& second)
{
  return {two(first.xyz, second.xyz), two(first.fourth, second.fourth)};
}
template <class Half>
inline Velocities<Two<Half>> two(const Velocities<Half>& first, const Velocities<Half>& second)
{
  return {two(first.velocity, second.velocity), two(first.spin, second.spin)};
}

/// What the force rows of the balls of contacts get.
template <class Number>
struct Loads {
  Vector3<Number> force;  ///< on i; on j the opposite
  Vector3<Number> torque_i, torque_j;
  Number damping;
};

template <class Half>
inline Vector3<Half> first_of(const Vector3<Two<Half>>& v)
{
  return {v.x.first, v.y.first, v.z.first};
}
template <class Half>
inline Vector3<Half> second_of(const Vector3<Two<Half>>& v)
{
  return {v.x.second, v.y.second, v.z.second};
}
template <class Half>
inline Columns<Half> first_of(const Columns<Two<Half>>& columns)
{
  return {first_of(columns.xyz), columns.fourth.first};
}
template <class Half>
inline Columns<Half> second_of(const Columns<Two<Half>>& columns)
{
  return {second_of(columns.xyz), columns.fourth.second};
}
template <class Half>
inline Loads<Half> first_of(const Loads<Two<Half>>& loads)
{
  return {first_of(loads.force), first_of(loads.torque_i), first_of(loads.torque_j),
          loads.damping.first};
}
template <class Half>
inline Loads<Half> second_of(const Loads<Two<Half>>& loads)
{
  return {second_of(loads.force), second_of(loads.torque_i), second_of(loads.torque_j),
          loads.damping.second};
}

/// A ball's index times eight. Rows have 32 or 64 bytes: the address of one needs no shift, since
/// x86-64 multiplies an index by four or eight.
using Ball = unsigned;

template <class Row>
inline Row& row_of(Row* rows, Ball ball)
{
  static_assert(sizeof(Row) == 32 || sizeof(Row) == 64);
  using Part = std::conditional_t<sizeof(Row) == 32, float, double>;
  auto* const first = reinterpret_cast<Part*>(const_cast<std::remove_const_t<Row>*>(rows));
  return *reinterpret_cast<Row*>(first + ball);
}

}  // namespace
}  // namespace millscale::kernels::MILLSCALE_LEVEL
