// Quantile of Student's distribution, for confidence intervals of 95 %.
#pragma once

namespace turgor {

/// t with P(|T| < t) = 95 % for a number of degrees of freedom from 1. Bisection of the exact probability, a
/// finite sum of powers of the cosine of θ = atan(t/√ν) [Abramowitz, Stegun 26.7.3 and 26.7.4]; from 200 on
/// two terms of the expansion of Cornish and Fisher, within 1e-6.
double student_quantile(int freedom);

}  // namespace turgor
