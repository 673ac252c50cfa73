#pragma once

// Packs of 64 bytes, for x86-64-v4.
#include "core/kernels/pack.h"

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

using Doubles = Pack<double, 8>;
using Singles = Pack<float, 16>;

/// Four rows of four numbers of contacts k and k + 4, or their columns.
struct DoubleRows {
  __m512d of[4];
};

/// Four rows of four numbers of contacts k, k + 4, k + 8 and k + 12, or their columns.
struct SingleRows {
  __m512 of[4];
};

inline __m512d two_rows(const double* first, const double* second)
{
  return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_loadu_pd(first)), _mm256_loadu_pd(second),
                            1);
}

inline __m512 two_rows(const float* first, const float* second)
{
  return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_load_ps(first)), _mm256_load_ps(second),
                            1);
}

inline DoubleRows transposed(const __m512d (&row)[4])
{
  const __m512i even = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
  const __m512i odd = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
  const __m512d low_ab = _mm512_unpacklo_pd(row[0], row[1]);
  const __m512d high_ab = _mm512_unpackhi_pd(row[0], row[1]);
  const __m512d low_cd = _mm512_unpacklo_pd(row[2], row[3]);
  const __m512d high_cd = _mm512_unpackhi_pd(row[2], row[3]);
  return {
      {_mm512_permutex2var_pd(low_ab, even, low_cd), _mm512_permutex2var_pd(high_ab, even, high_cd),
       _mm512_permutex2var_pd(low_ab, odd, low_cd), _mm512_permutex2var_pd(high_ab, odd, high_cd)}};
}

inline SingleRows transposed(const __m512 (&row)[4])
{
  const __m512 low_ab = _mm512_unpacklo_ps(row[0], row[1]);
  const __m512 high_ab = _mm512_unpackhi_ps(row[0], row[1]);
  const __m512 low_cd = _mm512_unpacklo_ps(row[2], row[3]);
  const __m512 high_cd = _mm512_unpackhi_ps(row[2], row[3]);
  return {{_mm512_shuffle_ps(low_ab, low_cd, 0x44), _mm512_shuffle_ps(low_ab, low_cd, 0xee),
           _mm512_shuffle_ps(high_ab, high_cd, 0x44), _mm512_shuffle_ps(high_ab, high_cd, 0xee)}};
}

/// Return the columns of row(k), the rows of contacts k and k + 4.
template <class Row>
inline Columns<Doubles> columns_of_doubles(const Row& row)
{
  const DoubleRows c = transposed({row(0), row(1), row(2), row(3)});
  return {{Doubles::of(c.of[0]), Doubles::of(c.of[1]), Doubles::of(c.of[2])}, Doubles::of(c.of[3])};
}

/// Return the columns of row(k), the rows of contacts k, k + 4, k + 8 and k + 12.
template <class Row>
inline Columns<Singles> columns_of_singles(const Row& row)
{
  const SingleRows c = transposed({row(0), row(1), row(2), row(3)});
  return {{Singles::of(c.of[0]), Singles::of(c.of[1]), Singles::of(c.of[2])}, Singles::of(c.of[3])};
}

/// Return the numbers of a column of doubles.
template <class Number>
inline Number from_doubles(const double* column);
template <>
inline Doubles from_doubles<Doubles>(const double* column)
{
  return Doubles::of(_mm512_loadu_pd(column));
}

inline void store_numbers(double* column, Doubles numbers)
{
  _mm512_storeu_pd(column, __m512d(numbers.values));
}

inline Singles singles(Doubles low, Doubles high)
{
  return Singles::of(
      _mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps(__m512d(low.values))),
                         _mm512_cvtpd_ps(__m512d(high.values)), 1));
}
template <>
inline Singles from_doubles<Singles>(const double* column)
{
  return singles(from_doubles<Doubles>(column), from_doubles<Doubles>(column + 8));
}

/// Return the columns of row(lane), four doubles of each contact.
template <class Number, class Row>
inline Columns<Number> columns(const Row& row)
{
  const auto two = [&](int k) {
    return _mm512_insertf64x4(_mm512_castpd256_pd512(row(k)), row(k + 4), 1);
  };
  if constexpr (Number::lanes == 8)
    return columns_of_doubles(two);
  else
    return columns_of_singles([&](int k) {
      return _mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps(two(k))),
                                _mm512_cvtpd_ps(two(k + 8)), 1);
    });
}

/// Return, for eight pairs, the differences of positions, and minus the sum of the radii.
inline Columns<Doubles> differences(const PositionRow* position, const int* i, const int* j)
{
  const __m512d signs = _mm512_setr_pd(1, 1, 1, -1, 1, 1, 1, -1);
  return columns_of_doubles([&](int k) {
    return _mm512_fmsub_pd(two_rows(&position[i[k]].x, &position[i[k + 4]].x), signs,
                           two_rows(&position[j[k]].x, &position[j[k + 4]].x));
  });
}

/// Return a bit for each lane whose number is above 0.
inline unsigned positive(Doubles a)
{
  return _mm512_cmp_pd_mask(__m512d(a.values), _mm512_setzero_pd(), _CMP_GT_OQ);
}

/// Eight ints.
using Ints = __m256i;

inline Ints ints(const int* numbers)
{
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(numbers));
}

/// Return first, first + step, ...
inline Ints ints_from(int first, int step)
{
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  return _mm256_add_epi32(_mm256_set1_epi32(first),
                          _mm256_mullo_epi32(lane, _mm256_set1_epi32(step)));
}

/// Return balls by their indices.
inline Ints balls(Ints index)
{
  return _mm256_slli_epi32(index, 3);
}

/// Return a bit for each int that is not 0.
inline unsigned nonzero(Ints flags)
{
  return _mm256_test_epi32_mask(flags, flags);
}

/// Store the chosen lanes one after the other. Up to eight numbers are written.
inline void store_chosen(double* to, unsigned bits, Doubles numbers)
{
  _mm512_storeu_pd(to, _mm512_maskz_compress_pd(bits, __m512d(numbers.values)));
}

template <class Int>
inline void store_chosen(Int* to, unsigned bits, Ints numbers)
{
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_maskz_compress_epi32(bits, numbers));
}

/// Return the velocities of a ball of each contact.
inline Velocities<Doubles> velocities(const VelocityRow* row, const Ball* ball)
{
  __m512d velocity[4], spin[4];
  for (int k = 0; k < 4; ++k) {
    const VelocityRow &a = row_of(row, ball[k]), &b = row_of(row, ball[k + 4]);
    velocity[k] = two_rows(a.velocity, b.velocity);
    spin[k] = two_rows(a.spin, b.spin);
  }
  return {columns_of_doubles([&](int k) { return velocity[k]; }),
          columns_of_doubles([&](int k) { return spin[k]; })};
}

inline Velocities<Singles> velocities(const SingleVelocityRow* row, const Ball* ball)
{
  const auto two = [&](int k) {
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_load_ps(row_of(row, ball[k]).velocity)),
                              _mm256_load_ps(row_of(row, ball[k + 8]).velocity), 1);
  };
  const __m512i first = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
  const __m512i last =
      _mm512_setr_epi32(4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31);
  return {
      columns_of_singles([&](int k) { return _mm512_permutex2var_ps(two(k), first, two(k + 4)); }),
      columns_of_singles([&](int k) { return _mm512_permutex2var_ps(two(k), last, two(k + 4)); })};
}

inline void store_three(double* to, __m256d numbers)
{
  _mm256_mask_storeu_pd(to, 7, numbers);
}

/// Store the first `count` rows of four numbers with store(lane, row).
template <class Store>
inline void store_each(const Store& store, int count, const Columns<Doubles>& c)
{
  const DoubleRows rows = transposed({__m512d(c.xyz.x.values), __m512d(c.xyz.y.values),
                                      __m512d(c.xyz.z.values), __m512d(c.fourth.values)});
  for (int k = 0; k < 4 && k < count; ++k) store(k, _mm512_castpd512_pd256(rows.of[k]));
  for (int k = 0; k < 4 && k + 4 < count; ++k) store(k + 4, _mm512_extractf64x4_pd(rows.of[k], 1));
}

template <class Store>
inline void store_each(const Store& store, int count, const Columns<Singles>& c)
{
  const SingleRows rows = transposed({__m512(c.xyz.x.values), __m512(c.xyz.y.values),
                                      __m512(c.xyz.z.values), __m512(c.fourth.values)});
  const auto store_row = [&](int lane, __m128 row) {
    if (lane < count) store(lane, _mm256_cvtps_pd(row));
  };
  for (int k = 0; k < 4; ++k) store_row(k, _mm512_castps512_ps128(rows.of[k]));
  for (int k = 0; k < 4; ++k) store_row(k + 4, _mm512_extractf32x4_ps(rows.of[k], 1));
  for (int k = 0; k < 4; ++k) store_row(k + 8, _mm512_extractf32x4_ps(rows.of[k], 2));
  for (int k = 0; k < 4; ++k) store_row(k + 12, _mm512_extractf32x4_ps(rows.of[k], 3));
}

/// Add the loads of the first `count` contacts to the rows of i and j, one contact after the other.
inline void add_loads(ForceRow* row, const Ball* i, const Ball* j, int count,
                      const Loads<Doubles>& loads)
{
  const auto m = [](Doubles a) { return __m512d(a.values); };
  const Doubles zero(0.0);
  const auto rows_of = [&](const Vector3<Doubles>& v, Doubles fourth) {
    return transposed({m(v.x), m(v.y), m(v.z), m(fourth)});
  };
  const Vector3<Doubles> none{zero, zero, zero};
  const DoubleRows force = rows_of(loads.force, zero);
  const DoubleRows on_i = rows_of(loads.torque_i, loads.damping);
  const DoubleRows on_j = rows_of(none - loads.torque_j, zero - loads.damping);
  const auto add = [&](int lane, __m512d to_i, __m512d from_j) {
    double* a = row_of(row, i[lane]).force;
    _mm512_store_pd(a, _mm512_add_pd(_mm512_load_pd(a), to_i));
    double* b = row_of(row, j[lane]).force;
    _mm512_store_pd(b, _mm512_sub_pd(_mm512_load_pd(b), from_j));
  };
  for (int k = 0; k < 4 && k < count; ++k)
    add(k, _mm512_shuffle_f64x2(force.of[k], on_i.of[k], 0x44),
        _mm512_shuffle_f64x2(force.of[k], on_j.of[k], 0x44));
  for (int k = 0; k < 4 && k + 4 < count; ++k)
    add(k + 4, _mm512_shuffle_f64x2(force.of[k], on_i.of[k], 0xee),
        _mm512_shuffle_f64x2(force.of[k], on_j.of[k], 0xee));
}

inline void add_loads(SingleForceRow* row, const Ball* i, const Ball* j, int count,
                      const Loads<Singles>& loads)
{
  const auto m = [](Singles a) { return __m512(a.values); };
  const Singles zero(0.0);
  const auto rows_of = [&](const Vector3<Singles>& v, Singles fourth) {
    return transposed({m(v.x), m(v.y), m(v.z), m(fourth)});
  };
  const Vector3<Singles> none{zero, zero, zero};
  const SingleRows force = rows_of(loads.force, loads.damping);
  const SingleRows back = rows_of(none - loads.force, loads.damping);
  const SingleRows on_i = rows_of(loads.torque_i, zero), on_j = rows_of(loads.torque_j, zero);
  const __m512i low = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
  const __m512i high =
      _mm512_setr_epi32(8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
  const auto add = [&](Ball ball, __m256 part) {
    float* to = row_of(row, ball).force;
    _mm256_store_ps(to, _mm256_add_ps(_mm256_load_ps(to), part));
  };
  for (int half = 0; half < 2; ++half) {
    __m512 to_i[4], to_j[4];
    for (int k = 0; k < 4; ++k) {
      to_i[k] = _mm512_permutex2var_ps(force.of[k], half ? high : low, on_i.of[k]);
      to_j[k] = _mm512_permutex2var_ps(back.of[k], half ? high : low, on_j.of[k]);
    }
    for (int k = 0; k < 4; ++k)
      if (const int lane = 8 * half + k; lane < count) {
        add(i[lane], _mm512_castps512_ps256(to_i[k]));
        add(j[lane], _mm512_castps512_ps256(to_j[k]));
      }
    for (int k = 0; k < 4; ++k)
      if (const int lane = 8 * half + 4 + k; lane < count) {
        add(i[lane], _mm512_extractf32x8_ps(to_i[k], 1));
        add(j[lane], _mm512_extractf32x8_ps(to_j[k], 1));
      }
  }
}

/// Return the k-th `width` of the numbers in double precision.
inline Doubles in_doubles(Doubles a, int)
{
  return a;
}
inline Doubles in_doubles(Singles a, int k)
{
  const __m512 all = __m512(a.values);
  return Doubles::of(
      _mm512_cvtps_pd(k == 0 ? _mm512_castps512_ps256(all) : _mm512_extractf32x8_ps(all, 1)));
}

/// Return the numbers as single precision keeps them.
inline Doubles as_kept(Doubles a)
{
  return Doubles::of(_mm512_cvtps_pd(_mm512_cvtpd_ps(__m512d(a.values))));
}
inline Singles as_kept(Singles a)
{
  return a;
}

/// Return numbers that are kept in single precision.
inline Doubles from_singles(const float* column, Doubles)
{
  return Doubles::of(_mm512_cvtps_pd(_mm256_loadu_ps(column)));
}
inline Singles from_singles(const float* column, Singles)
{
  return Singles::of(_mm512_loadu_ps(column));
}
inline void store_numbers(float* column, Doubles numbers)
{
  _mm256_storeu_ps(column, _mm512_cvtpd_ps(__m512d(numbers.values)));
}
inline void store_numbers(float* column, Singles numbers)
{
  _mm512_storeu_ps(column, __m512(numbers.values));
}

/// Return what this rank counts of each pair: 1/2 of one with a ghost, 0 from the lane `count` on.
inline Doubles shares(const Ball* j, Ball ghosts, int count)
{
  const __mmask8 with_ghosts = _mm256_cmpge_epu32_mask(ints(reinterpret_cast<const int*>(j)),
                                                       _mm256_set1_epi32(static_cast<int>(ghosts)));
  const __mmask8 there =
      static_cast<__mmask8>(_bzhi_u32(0xff, count < 0 ? 0u : static_cast<unsigned>(count)));
  return Doubles::of(_mm512_mask_blend_pd(with_ghosts,
                                          _mm512_maskz_mov_pd(there, _mm512_set1_pd(1.0)),
                                          _mm512_maskz_mov_pd(there, _mm512_set1_pd(0.5))));
}

}  // namespace
}  // namespace millscale::kernels::MILLSCALE_LEVEL
