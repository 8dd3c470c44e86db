from .case import Computation as Computation
from .case import DeviationKind as DeviationKind
from .case import Outcome as Outcome
from .case import VerificationCase as VerificationCase
from .cases import verification_case as verification_case
from .cases import verification_cases as verification_cases
from .compute import verify as verify
from .result import Verification as Verification
