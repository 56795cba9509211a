"""The one kind of array the solver works on."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
