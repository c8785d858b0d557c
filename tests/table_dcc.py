"""The DCC of a rate table, as small as the schema allows."""

RATE, DEGREE = r"\degree\second\tothe{-1}", r"\degree"


def listed(ref_type: str, values: str, unit: str, U: str = "", k: str = "2") -> str:
    expanded = (
        f"<si:measurementUncertaintyUnivariateXMLList><si:expandedMUXMLList>"
        f"<si:valueExpandedMUXMLList>{U}</si:valueExpandedMUXMLList>"
        f"<si:coverageFactorXMLList>{k}</si:coverageFactorXMLList>"
        f"<si:coverageProbabilityXMLList>0.95</si:coverageProbabilityXMLList>"
        f"</si:expandedMUXMLList></si:measurementUncertaintyUnivariateXMLList>"
    )
    return quantity(
        ref_type,
        f"<si:realListXMLList><si:valueXMLList>{values}</si:valueXMLList>"
        f"<si:unitXMLList>{unit}</si:unitXMLList>{expanded if U else ''}</si:realListXMLList>",
    )


def single(ref_type: str, value: str, unit: str, U: str = "") -> str:
    expanded = (
        f"<si:measurementUncertaintyUnivariate><si:expandedMU>"
        f"<si:valueExpandedMU>{U}</si:valueExpandedMU><si:coverageFactor>2</si:coverageFactor>"
        f"<si:coverageProbability>0.95</si:coverageProbability></si:expandedMU>"
        f"</si:measurementUncertaintyUnivariate>"
    )
    return quantity(
        ref_type,
        f"<si:real><si:value>{value}</si:value><si:unit>{unit}</si:unit>"
        f"{expanded if U else ''}</si:real>",
    )


def quantity(ref_type: str, content: str) -> str:
    name = '<dcc:name><dcc:content lang="en">q</dcc:content></dcc:name>'
    return f'<dcc:quantity refType="{ref_type}">{name}{content}</dcc:quantity>'


def result(name: str, *quantities: str) -> str:
    return (
        f'<dcc:result><dcc:name><dcc:content lang="en">{name}</dcc:content></dcc:name>'
        f"<dcc:data><dcc:list>{''.join(quantities)}</dcc:list></dcc:data></dcc:result>"
    )


def content(tag: str, en: str, zh: str = "台") -> str:
    return (
        f'<dcc:{tag}><dcc:content lang="zh">{zh}</dcc:content>'
        f'<dcc:content lang="en">{en}</dcc:content></dcc:{tag}>'
    )


def document(*results: str) -> str:
    one = content("name", "-")
    return (
        '<dcc:digitalCalibrationCertificate xmlns:dcc="https://ptb.de/dcc" '
        'xmlns:si="https://ptb.de/si" schemaVersion="3.3.0"><dcc:administrativeData>'
        f"<dcc:dccSoftware><dcc:software>{one}<dcc:release>1</dcc:release></dcc:software>"
        "</dcc:dccSoftware><dcc:coreData>"
        "<dcc:countryCodeISO3166_1>CN</dcc:countryCodeISO3166_1>"
        "<dcc:usedLangCodeISO639_1>en</dcc:usedLangCodeISO639_1>"
        "<dcc:mandatoryLangCodeISO639_1>en</dcc:mandatoryLangCodeISO639_1>"
        "<dcc:uniqueIdentifier>CNAS 2026-117</dcc:uniqueIdentifier>"
        "<dcc:beginPerformanceDate>2026-02-27</dcc:beginPerformanceDate>"
        "<dcc:endPerformanceDate>2026-03-01</dcc:endPerformanceDate>"
        "<dcc:performanceLocation>laboratory</dcc:performanceLocation></dcc:coreData>"
        f"<dcc:items><dcc:item>{content('name', 'Rate table', '转台')}<dcc:identifications>"
        "<dcc:identification><dcc:issuer>manufacturer</dcc:issuer>"
        f"<dcc:value>TT-07</dcc:value>{one}</dcc:identification></dcc:identifications>"
        "</dcc:item></dcc:items><dcc:calibrationLaboratory>"
        f"<dcc:contact>{one}<dcc:location><dcc:countryCode>CN</dcc:countryCode></dcc:location>"
        "</dcc:contact></dcc:calibrationLaboratory><dcc:respPersons><dcc:respPerson>"
        f"<dcc:person>{one}</dcc:person></dcc:respPerson></dcc:respPersons><dcc:customer>{one}"
        "<dcc:location><dcc:countryCode>CN</dcc:countryCode></dcc:location></dcc:customer>"
        "</dcc:administrativeData><dcc:measurementResults><dcc:measurementResult>"
        f"{one}<dcc:results>{''.join(results)}</dcc:results>"
        "</dcc:measurementResult></dcc:measurementResults></dcc:digitalCalibrationCertificate>"
    )


RATES = result(
    "inner",
    listed("basic_nominalValue", "10 100 -100", RATE),
    listed("basic_measurementError", "0.001 -0.002 0.004", RATE, "0.0002 0.001 0.001", "2"),
)
ANGLES = result(
    "inner",
    *[
        single("basic_nominalValue", at, DEGREE)
        + single("basic_measurementError", error, r"\arcsecond", "1.5")
        for at, error in (("0", "0"), ("90", "2.5"), ("360", "0"))
    ],
)
