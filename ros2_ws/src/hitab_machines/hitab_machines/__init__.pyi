from .machine_signs import MachineSigns as MachineSigns
