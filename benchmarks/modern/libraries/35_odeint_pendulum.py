"""
the trace of a pendulum
"""
from helper import *
import numpy as np
from scipy.integrate import solve_ivp, odeint


@register()
def trace() -> Shape:
    def f(state, t):
        theta, omega = state
        return [omega, -9.81 / 2 * np.sin(theta)]

    path = odeint(f, [1.0, 0.0], np.linspace(0, 2, 20))
    shapes = []
    for theta, omega in path:
        shapes.append(transform_shape(primitive_call('sphere', color=(.2, .2, .8), shape_kwargs={'radius': .1}), translation_matrix((2 * np.sin(theta), -2 * np.cos(theta), .2 * omega))))
    return concat_shapes(*shapes)
