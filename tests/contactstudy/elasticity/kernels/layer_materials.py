"""Layers that the tests share: alike and unlike, compressible or not, on a soft, a stiff and a rigid base."""

from contactstudy.elasticity.kernels.layer_response import LayerResponse

LAYERS = {
    "stiff": LayerResponse((4.0,), (0.25, 0.35)),
    "very stiff": LayerResponse((1e3,), (0.3, 0.3)),
    "very soft": LayerResponse((1e-3,), (0.3, 0.45)),
    "rubber on a rigid base": LayerResponse((0.0,), (0.5, 0.3)),
    "soft between stiff": LayerResponse((300.0, 0.5), (0.25, 0.4, 0.3), (0.4, 1.0)),
    "two on a rigid base": LayerResponse((0.2, 5.0, 0.0), (0.3, 0.45, 0.2, 0.3), (0.3, 0.5, 1.0)),
    "alike": LayerResponse((1.02,), (0.28, 0.3)),
}
