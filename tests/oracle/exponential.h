/* The exponential of a matrix in double precision (Eigen). It takes several seconds to compile and is
 * therefore compiled once, for one size: a smaller system uses the top left corner, with zeros around it. */
#ifndef TESTS_ORACLE_EXPONENTIAL_H
#define TESTS_ORACLE_EXPONENTIAL_H

#include <Eigen/Dense>

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

Matrix9 oracle_exponential(const Matrix9 &matrix);

#endif
