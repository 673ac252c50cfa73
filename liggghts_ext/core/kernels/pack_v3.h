#pragma once

// Packs of 32 bytes, for x86-64-v3.
#include "core/kernels/pack.h"

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

using Doubles = Pack<double, 4>;
using Singles = Pack<float, 8>;

/// Four rows of four numbers of contacts, or their columns.
struct DoubleRows {
  __m256d of[4];
};

/// Four rows of four numbers of contacts k and k + 4, or their columns.
struct SingleRows {
  __m256 of[4];
};

inline DoubleRows transposed(const __m256d (&row)[4])
{
  const __m256d low_ab = _mm256_unpacklo_pd(row[0], row[1]);
  const __m256d high_ab = _mm256_unpackhi_pd(row[0], row[1]);
  const __m256d low_cd = _mm256_unpacklo_pd(row[2], row[3]);
  const __m256d high_cd = _mm256_unpackhi_pd(row[2], row[3]);
  return {{_mm256_permute2f128_pd(low_ab, low_cd, 0x20),
           _mm256_permute2f128_pd(high_ab, high_cd, 0x20),
           _mm256_permute2f128_pd(low_ab, low_cd, 0x31),
           _mm256_permute2f128_pd(high_ab, high_cd, 0x31)}};
}

inline SingleRows transposed(const __m256 (&row)[4])
{
  const __m256 low_ab = _mm256_unpacklo_ps(row[0], row[1]);
  const __m256 high_ab = _mm256_unpackhi_ps(row[0], row[1]);
  const __m256 low_cd = _mm256_unpacklo_ps(row[2], row[3]);
  const __m256 high_cd = _mm256_unpackhi_ps(row[2], row[3]);
  return {{_mm256_shuffle_ps(low_ab, low_cd, 0x44), _mm256_shuffle_ps(low_ab, low_cd, 0xee),
           _mm256_shuffle_ps(high_ab, high_cd, 0x44), _mm256_shuffle_ps(high_ab, high_cd, 0xee)}};
}

/// Return two rows of four side by side.
inline __m256 beside(__m128 first, __m128 second)
{
  return _mm256_insertf128_ps(_mm256_castps128_ps256(first), second, 1);
}

/// Return the columns of row(k), the rows of the contacts.
template <class Row>
inline Columns<Doubles> columns_of_doubles(const Row& row)
{
  const DoubleRows c = transposed({row(0), row(1), row(2), row(3)});
  return {{Doubles::of(c.of[0]), Doubles::of(c.of[1]), Doubles::of(c.of[2])}, Doubles::of(c.of[3])};
}

/// Return the columns of row(k), the rows of contacts k and k + 4.
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
  return Doubles::of(_mm256_loadu_pd(column));
}

inline void store_numbers(double* column, Doubles numbers)
{
  _mm256_storeu_pd(column, __m256d(numbers.values));
}

inline Singles singles(Doubles low, Doubles high)
{
  return Singles::of(
      beside(_mm256_cvtpd_ps(__m256d(low.values)), _mm256_cvtpd_ps(__m256d(high.values))));
}
template <>
inline Singles from_doubles<Singles>(const double* column)
{
  return singles(from_doubles<Doubles>(column), from_doubles<Doubles>(column + 4));
}

/// Return the columns of row(lane), four doubles of each contact.
template <class Number, class Row>
inline Columns<Number> columns(const Row& row)
{
  if constexpr (Number::lanes == 4)
    return columns_of_doubles(row);
  else
    return columns_of_singles(
        [&](int k) { return beside(_mm256_cvtpd_ps(row(k)), _mm256_cvtpd_ps(row(k + 4))); });
}

/// Return, for four pairs, the differences of positions, and minus the sum of the radii.
inline Columns<Doubles> differences(const PositionRow* position, const int* i, const int* j)
{
  const __m256d signs = _mm256_setr_pd(1, 1, 1, -1);
  return columns_of_doubles([&](int k) {
    return _mm256_fmsub_pd(_mm256_load_pd(&position[i[k]].x), signs,
                           _mm256_load_pd(&position[j[k]].x));
  });
}

/// Return a bit for each lane whose number is above 0.
inline unsigned positive(Doubles a)
{
  return _mm256_movemask_pd(_mm256_cmp_pd(__m256d(a.values), _mm256_setzero_pd(), _CMP_GT_OQ));
}

/// Four ints.
using Ints = __m128i;

inline Ints ints(const int* numbers)
{
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(numbers));
}

/// Return first, first + step, ...
inline Ints ints_from(int first, int step)
{
  return _mm_add_epi32(_mm_set1_epi32(first),
                       _mm_mullo_epi32(_mm_setr_epi32(0, 1, 2, 3), _mm_set1_epi32(step)));
}

/// Return balls by their indices.
inline Ints balls(Ints index)
{
  return _mm_slli_epi32(index, 3);
}

/// Return a bit for each int that is not 0.
inline unsigned nonzero(Ints flags)
{
  return 15 & ~_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpeq_epi32(flags, _mm_setzero_si128())));
}

/// For each combination of four bits: the lanes of its bits in ascending order, as indices of ints
/// and as indices of the halves of doubles.
struct Chosen {
  alignas(32) int halves[8];
  alignas(16) int lane[4];
};
constexpr int chosen_lane(int bits, int rank)
{
  for (int lane = 0; lane < 4; ++lane)
    if ((bits >> lane & 1) && rank-- == 0) return lane;
  return 0;
}
struct ChosenTable {
  Chosen of[16];
};
constexpr ChosenTable all_chosen()
{
  ChosenTable all{};
  for (int bits = 0; bits < 16; ++bits)
    for (int rank = 0; rank < 4; ++rank) {
      const int lane = chosen_lane(bits, rank);
      all.of[bits].lane[rank] = lane;
      all.of[bits].halves[2 * rank] = 2 * lane;
      all.of[bits].halves[2 * rank + 1] = 2 * lane + 1;
    }
  return all;
}
constexpr ChosenTable chosen = all_chosen();

/// Store the chosen lanes one after the other. Up to four numbers are written.
inline void store_chosen(double* to, unsigned bits, Doubles numbers)
{
  const __m256i order = _mm256_load_si256(reinterpret_cast<const __m256i*>(chosen.of[bits].halves));
  _mm256_storeu_pd(to, _mm256_castps_pd(_mm256_permutevar8x32_ps(
                           _mm256_castpd_ps(__m256d(numbers.values)), order)));
}

template <class Int>
inline void store_chosen(Int* to, unsigned bits, Ints numbers)
{
  const __m128i order = _mm_load_si128(reinterpret_cast<const __m128i*>(chosen.of[bits].lane));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to),
                   _mm_castps_si128(_mm_permutevar_ps(_mm_castsi128_ps(numbers), order)));
}

/// Return the velocities of a ball of each contact.
inline Velocities<Doubles> velocities(const VelocityRow* row, const Ball* ball)
{
  __m256d velocity[4], spin[4];
  for (int k = 0; k < 4; ++k) {
    velocity[k] = _mm256_load_pd(row_of(row, ball[k]).velocity);
    spin[k] = _mm256_load_pd(row_of(row, ball[k]).spin);
  }
  return {columns_of_doubles([&](int k) { return velocity[k]; }),
          columns_of_doubles([&](int k) { return spin[k]; })};
}

inline Velocities<Singles> velocities(const SingleVelocityRow* row, const Ball* ball)
{
  return {columns_of_singles([&](int k) {
            return beside(_mm_load_ps(row_of(row, ball[k]).velocity),
                          _mm_load_ps(row_of(row, ball[k + 4]).velocity));
          }),
          columns_of_singles([&](int k) {
            return beside(_mm_load_ps(row_of(row, ball[k]).spin),
                          _mm_load_ps(row_of(row, ball[k + 4]).spin));
          })};
}

/// Store three numbers without a masked store, which is slow on some machines.
inline void store_three(double* to, __m256d numbers)
{
  _mm_storeu_pd(to, _mm256_castpd256_pd128(numbers));
  _mm_store_sd(to + 2, _mm256_extractf128_pd(numbers, 1));
}

/// Store the first `count` rows of four numbers with store(lane, row).
template <class Store>
inline void store_each(const Store& store, int count, const Columns<Doubles>& c)
{
  const DoubleRows rows = transposed({__m256d(c.xyz.x.values), __m256d(c.xyz.y.values),
                                      __m256d(c.xyz.z.values), __m256d(c.fourth.values)});
  for (int k = 0; k < 4 && k < count; ++k) store(k, rows.of[k]);
}

template <class Store>
inline void store_each(const Store& store, int count, const Columns<Singles>& c)
{
  const SingleRows rows = transposed({__m256(c.xyz.x.values), __m256(c.xyz.y.values),
                                      __m256(c.xyz.z.values), __m256(c.fourth.values)});
  for (int k = 0; k < 4 && k < count; ++k)
    store(k, _mm256_cvtps_pd(_mm256_castps256_ps128(rows.of[k])));
  for (int k = 0; k < 4 && k + 4 < count; ++k)
    store(k + 4, _mm256_cvtps_pd(_mm256_extractf128_ps(rows.of[k], 1)));
}

/// Add the loads of the first `count` contacts to the rows of i and j, one contact after the other.
inline void add_loads(ForceRow* row, const Ball* i, const Ball* j, int count,
                      const Loads<Doubles>& loads)
{
  const auto m = [](Doubles a) { return __m256d(a.values); };
  const auto rows_of = [&](const Vector3<Doubles>& v, Doubles fourth) {
    return transposed({m(v.x), m(v.y), m(v.z), m(fourth)});
  };
  const auto add = [](double* to, __m256d part) {
    _mm256_store_pd(to, _mm256_add_pd(_mm256_load_pd(to), part));
  };
  const DoubleRows force = rows_of(loads.force, Doubles(0.0));
  const DoubleRows on_i = rows_of(loads.torque_i, loads.damping);
  const DoubleRows on_j = rows_of(loads.torque_j, loads.damping);
  for (int k = 0; k < 4 && k < count; ++k) {
    ForceRow &a = row_of(row, i[k]), &b = row_of(row, j[k]);
    add(a.force, force.of[k]);
    add(a.torque, on_i.of[k]);
    _mm256_store_pd(b.force, _mm256_sub_pd(_mm256_load_pd(b.force), force.of[k]));
    add(b.torque, on_j.of[k]);
  }
}

inline void add_loads(SingleForceRow* row, const Ball* i, const Ball* j, int count,
                      const Loads<Singles>& loads)
{
  const auto m = [](Singles a) { return __m256(a.values); };
  const Singles zero(0.0);
  const auto rows_of = [&](const Vector3<Singles>& v, Singles fourth) {
    return transposed({m(v.x), m(v.y), m(v.z), m(fourth)});
  };
  const auto add = [&](Ball ball, __m256 part) {
    float* to = row_of(row, ball).force;
    _mm256_store_ps(to, _mm256_add_ps(_mm256_load_ps(to), part));
  };
  const Vector3<Singles> none{zero, zero, zero};
  const SingleRows force = rows_of(loads.force, loads.damping);
  const SingleRows back = rows_of(none - loads.force, loads.damping);
  const SingleRows on_i = rows_of(loads.torque_i, zero), on_j = rows_of(loads.torque_j, zero);
  for (int k = 0; k < 4 && k < count; ++k) {
    add(i[k], _mm256_permute2f128_ps(force.of[k], on_i.of[k], 0x20));
    add(j[k], _mm256_permute2f128_ps(back.of[k], on_j.of[k], 0x20));
  }
  for (int k = 0; k < 4 && k + 4 < count; ++k) {
    add(i[k + 4], _mm256_permute2f128_ps(force.of[k], on_i.of[k], 0x31));
    add(j[k + 4], _mm256_permute2f128_ps(back.of[k], on_j.of[k], 0x31));
  }
}

/// Return the k-th `width` of the numbers in double precision.
inline Doubles in_doubles(Doubles a, int)
{
  return a;
}
inline Doubles in_doubles(Singles a, int k)
{
  const __m256 all = __m256(a.values);
  return Doubles::of(
      _mm256_cvtps_pd(k == 0 ? _mm256_castps256_ps128(all) : _mm256_extractf128_ps(all, 1)));
}

/// Return the numbers as single precision keeps them.
inline Doubles as_kept(Doubles a)
{
  return Doubles::of(_mm256_cvtps_pd(_mm256_cvtpd_ps(__m256d(a.values))));
}
inline Singles as_kept(Singles a)
{
  return a;
}

/// Return numbers that are kept in single precision.
inline Doubles from_singles(const float* column, Doubles)
{
  return Doubles::of(_mm256_cvtps_pd(_mm_loadu_ps(column)));
}
inline Singles from_singles(const float* column, Singles)
{
  return Singles::of(_mm256_loadu_ps(column));
}
inline void store_numbers(float* column, Doubles numbers)
{
  _mm_storeu_ps(column, _mm256_cvtpd_ps(__m256d(numbers.values)));
}
inline void store_numbers(float* column, Singles numbers)
{
  _mm256_storeu_ps(column, __m256(numbers.values));
}

/// Return what this rank counts of each pair: 1/2 of one with a ghost, 0 from the lane `count` on.
inline Doubles shares(const Ball* j, Ball ghosts, int count)
{
  const __m128i of_rank = _mm_cmplt_epi32(ints(reinterpret_cast<const int*>(j)),
                                          _mm_set1_epi32(static_cast<int>(ghosts)));
  const __m128i there = _mm_cmplt_epi32(_mm_setr_epi32(0, 1, 2, 3), _mm_set1_epi32(count));
  const auto chosen = [](__m128i lanes, __m256d yes, __m256d no) {
    return _mm256_blendv_pd(no, yes, _mm256_castsi256_pd(_mm256_cvtepi32_epi64(lanes)));
  };
  const __m256d all = chosen(of_rank, _mm256_set1_pd(1.0), _mm256_set1_pd(0.5));
  return Doubles::of(chosen(there, all, _mm256_setzero_pd()));
}

}  // namespace
}  // namespace millscale::kernels::MILLSCALE_LEVEL
