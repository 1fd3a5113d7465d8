# Whether two estimates of one picture agree, and what each costs. Pictures are arrays [height][width][3].
#
# A renderer is run several times with different seeds. Its estimate is the mean of the runs; a pixel's variance is
# that between the runs. Of independent pixels, a block's variance is the sum of theirs: known far better from a few
# runs than by the few means of each block. Cycles' pixels share a few tables of samples, so that its blocks spread a
# little more than that; by how much, all blocks together tell well.
import math
from dataclasses import dataclass

import numpy


@dataclass
class Runs:
    """What one renderer found at one number of samples a pixel."""
    samples: int
    seconds: list
    mean: numpy.ndarray      # of all runs
    variance: numpy.ndarray  # of one run's pixels, between the runs
    error2: numpy.ndarray    # squared standard error of `mean`, as the renderer or the runs tell it
    told: bool               # by the renderer
    pictures: list


def gather(samples, seconds, pictures, errors=None):
    stack = numpy.stack(pictures).astype(numpy.float64)
    if not numpy.isfinite(stack).all():
        raise ValueError(f"{numpy.count_nonzero(~numpy.isfinite(stack))} values are not finite")
    variance = stack.var(axis=0, ddof=1)
    error2 = variance / len(stack) if errors is None else sum(e.astype(float)**2 for e in errors) / len(stack)**2
    return Runs(samples, seconds, stack.mean(axis=0), variance, error2, errors is not None, pictures)


def block_sums(picture, side):
    height, width, channels = picture.shape
    return picture.reshape(height // side, side, width // side, side, channels).sum(axis=(1, 3))


# Differences of block means in standard errors; NaN where neither picture has any noise and both are equal but for
# what 32 bits round off: a millionth of what is there, and of the picture's mean.
def block_z(a, b, side):
    difference = block_sums(a.mean - b.mean, side)
    error = numpy.sqrt(sum(block_sums(r.error2, side) * joint(r, side) for r in (a, b)))
    rounded = 1e-6 * (block_sums(b.mean, side) + side * side * b.mean.mean())
    difference[(error < rounded) & (abs(difference) < rounded)] = numpy.nan
    with numpy.errstate(divide="ignore", invalid="ignore"):
        return difference / error


@dataclass
class Blocks:
    side: int
    number: int      # blocks with noise
    mean: float      # of z, over blocks and channels
    rms: float
    beyond: float    # share of |z| above 3; 0.0027 where z is normal
    largest: float
    agree: bool


# The channels of a block share their paths, so that a block counts once where chance is allowed for: rms of z may
# exceed 1, and the share above 3 what a normal z gives, by three standard deviations.
def compare_blocks(a, b, side):
    z = block_z(a, b, side)
    number, expected = max(1, (~numpy.isnan(z)).any(axis=2).sum()), math.erfc(3 / math.sqrt(2))
    z = z[~numpy.isnan(z)]
    rms, beyond = math.sqrt(numpy.mean(z**2)), numpy.mean(numpy.abs(z) > 3)
    agree = (rms <= 1 + 3 / math.sqrt(2 * number)
             and beyond <= expected + 3 * math.sqrt(expected * (1 - expected) / number))
    return Blocks(side, number, numpy.mean(z), rms, beyond, numpy.abs(z).max(), bool(agree))


# How far block means spread between the runs, over what the pixels' variance predicts: 1 where pixels are independent.
# Blocks count alike, so that the few at the lamp's edges do not decide.
def spread(runs, side):
    sums = numpy.stack([block_sums(p.astype(numpy.float64), side) for p in runs.pictures])
    predicted = block_sums(runs.variance, side)
    noisy = predicted > (1e-6 * side * runs.mean.mean())**2
    return math.sqrt((sums.var(axis=0, ddof=1)[noisy] / predicted[noisy]).mean())


# What a sum of pixels' variances is multiplied by, so that it is the variance of the sum. Pixels of whom the renderer
# tells the error are held to that.
def joint(runs, side):
    return 1 if runs.told else spread(runs, side)**2


# The standard error that a renderer tells, over what its runs show: 1 where it is right.
def told_error(runs):
    return math.sqrt(runs.error2.sum() / (runs.variance.sum() / len(runs.pictures)))


@dataclass
class Means:
    relative: float  # a / b - 1
    error: float     # its standard error


def compare_means(a, b, where):
    mean = b.mean[where].mean()
    count = b.mean[where].size
    # The channels' errors are added as if they were one: an upper bound, since they share their paths.
    error = math.sqrt(3 * sum(r.error2[where].sum() * joint(r, 64) for r in (a, b))) / count
    return Means(a.mean[where].mean() / mean - 1, error / mean)


def mean_variance(runs, where):
    return runs.variance[where].mean()


# Seconds at which a renderer measured at several numbers of samples reaches `variance`: between and beyond its points
# a straight line in logarithms, of slope -1 where there is one point.
def seconds_for(variance, variances, seconds):
    x, y = numpy.log(variances), numpy.log(seconds)
    order = numpy.argsort(x)
    x, y, at = x[order], y[order], math.log(variance)
    if len(x) == 1:
        return math.exp(y[0] + x[0] - at)
    i = min(max(int(numpy.searchsorted(x, at)), 1), len(x) - 1)
    return math.exp(y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]))
