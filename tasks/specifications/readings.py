"""Register of interpretations: where a specification is wrong or silent, and what is used.

A result names the readings it rests on by their keys; the certificate prints them. What was taken
stands in the catalogues under `reading-…`.
"""

from dataclasses import dataclass

from tasks.words import Message, message


@dataclass(frozen=True)
class Reading:
    """A clause that had to be interpreted."""

    key: str
    clause: str

    @property
    def text(self) -> Message:
        """How the clause was read."""
        return message(f"reading-{self.key.replace('.', '-').replace('_', '-')}")


_CLAUSES = {
    "jjf2003.p_turning": "JJF 2003-2022, 7.2.5.2, eq. (12), (13)",
    "jjf2003.p_sign": "JJF 2003-2022, 5.2 eq. (2) and 7.2.5.2 eq. (12), (13)",
    "jjf2003.p_lever_arm": "JJF 2003-2022, 7.2.5",
    "jjf2003.p_rates": "JJF 2003-2022, 7.2.5.1 b)",
    "jjf2003.p_unit": "JJF 2003-2022, 7.2.5.2 and Appendix B, 6",
    "jjf2003.g_earth": "JJF 2003-2022, 7.2.2.2 eq. (7)",
    "jjf2003.input_matrix": "JJF 2003-2022, 7.2.2.2",
    "jjf2003.k_azx": "JJF 2003-2022, 5.2, list under eq. (2)",
    "jjf2003.k_gzy": "JJF 2003-2022, Appendix B, 3",
    "jjf2003.positions": "JJF 2003-2022, 7.2.2.1 and Appendix C",
    "jjf2003.u_gx1": "JJF 2003-2022, Appendix A, A.3.2.3",
    "jjf2003.table_rate": "JJF 2003-2022, 7.2.1.2 eq. (4)",
    "jjf2003.turned_angle": "JJF 2003-2022, 7.2.1",
    "jjf1536.output_rate": "JJF 1536-2015, 7.1.1 b), d) and 7.1.2 eq. (10)",
    "jjf1536.table_rate": "JJF 1536-2015, 7.1.2 eq. (13)",
    "jjf1536.zero_time": "JJF 1536-2015, 7.2.3 eq. (16) and eq. (A.4)",
    "jjf1536.earth_cancels": "JJF 1536-2015, 7.2.1, 7.2.2",
    "jjf1536.turns_divisor": "JJF 1536-2015, 5.6 to 5.8 eq. (7), (8), (9) and 7.3.2 eq. (17)",
    "jjf1536.l_yz": "JJF 1536-2015, 5.8 eq. (9)",
    "jjf1536.index_order": "JJF 1536-2015, 7.3.1, Table 3, 7.3.2 eq. (17) and Appendix C",
    "jjf1536.turned_angle": "JJF 1536-2015, 7.3.2 eq. (17)",
    "jjf1536.product": "JJF 1536-2015, 5.1 eq. (2)",
    "jjf1536.attitude": "JJF 1536-2015, Appendix B eq. (B.4)",
    "joint.method": "JJF 2003-2022, 5.1 eq. (1), 5.2 eq. (2)",
    "joint.g_earth": "JJF 2003-2022, 5.1 eq. (1)",
    "joint.fit_offset": "JJF 2003-2022, 7.2.1.2 eq. (4)",
    "joint.gravity_alone": "JJF 2003-2022, 5.2 eq. (2)",
    "joint.gravity_moves": "JJF 2003-2022, 5.1 eq. (1)",
}
READINGS = {key: Reading(key, clause) for key, clause in _CLAUSES.items()}
